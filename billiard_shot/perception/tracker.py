"""
Where the balls lie, from detections with errors, losses, doubled boxes and wrong classes.

A track is one ball. In each picture all tracks get their detections at once, by the assignment of
the largest likelihood: of distances from the expected places, and of wrong classes (global nearest
neighbour: Blackman and Popoli, "Design and Analysis of Modern Tracking Systems", 1999, section 6).
A detection that is left begins a track only far from all balls that the picture shows, because
balls are a diameter apart, and not over a pocket. A new track is a ball once most pictures have
shown it. Its class is the one that most of its last detections have. A class has a given number of
balls: the first has the name of the class, the second of the class `solid` is `solid_2`, and so
on. A ball that is found again gets the name of one that is not seen.

While a ball rests, its position is the mean of a window of detections, and the covariance of the
mean falls as the window grows. Two tests for a change of the mean, with the newest detections and
with the newer half of the window, drop the detections from before a motion, so that the window
holds one resting place (windows that a test for change cuts: Bifet and Gavalda, "Learning from
time-changing data with adaptive windowing", SDM 2007).
"""

from collections import Counter, deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import count, islice
import math
from types import MappingProxyType
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from billiard_shot.perception.gate import MAX_BALLS, MAX_DEVIATION
from billiard_shot.perception.sightings import Sighting
from billiard_shot.records import Array
from billiard_shot.scene.fields import CheckedRecord, number, whole_number
from billiard_shot.scene.placement import Place

CHANGE = 36.0
"""
Square of the distance, in standard deviations, beyond which two positions differ.

The errors in x and y being normal, the square exceeds it with a probability of exp(-18), 1.5e-8.
"""

ELSEWHERE = 3
"""Number of successive detections elsewhere after which a resting ball is taken to have moved."""

BEFORE_FALL = 0.1
"""Time before the fall into a pocket for which a ball need not be detected [s]: three pictures."""

BESIDE_HOLE = 0.05
"""Distance from a hole within which a camera may see no ball [m], as the rail is in its way."""

ROLLING = 0.1
"""Deceleration of a rolling ball [m/s^2]; see `rolling_friction` of scenes."""

OF_VELOCITY = 4
"""Number of last detections that give the velocity of a ball."""

APART = 0.9
"""Smallest distance between detections of two balls [diameters]: they touch at 1, less errors."""

CONFIRMED = 7
"""
Score at which a new track is a ball: a picture with a detection counts 1, one without -1.

This is a sequential test (Wald 1945) of tracks that 80 % of the pictures show against those that
20 % show; below 0 the track ends. A false ball in 20 % of the pictures passes once in 4,000 times.
"""

MOVING_VOTES = 15
"""Number of last detections that give the class of a moving ball: it may be taken for another."""

MIN_SHARE = 1 / 3
"""Smallest share of the detections of a track whose class can give it a new name."""

ONE_CLASS = MappingProxyType[str, int]({})

# Negative logarithms of likelihoods, relative to those of a detection of the right class at the
# expected place. The chances are of a poor detector; the assignment is the same for similar ones.
JUMP = 8.0  # a motion that was not expected (5 % of the pictures), to any place within reach (1 %)
WRONG_CLASS = 5.0  # 10 % of the detections, one class of 15
NOT_DETECTED = 1.6  # 20 % of the balls in a picture
FALSE = 9.0  # a detection where no ball is
DOUBLED = 3.0  # 5 % of the balls have a second box
NEW = 3.0  # the track of a detection that may be false
FOUND = 6.0  # a ball that was not seen for long; with a wrong class, the detection is false
IMPOSSIBLE = 1e6

MAX_SPEED = 10.0
"""Largest speed of a ball [m/s]; breaks reach it."""


@dataclass(frozen=True, slots=True)
class Detection:
    """One ball that a camera has detected."""

    kind: str  # class of the ball; may be wrong
    position: Place  # centre, x and y in the frame `table`, m
    covariance: tuple[float, float, float]  # of the position: xx, xy, yy, m^2; not zero


@dataclass(frozen=True, slots=True)
class TrackerSettings(CheckedRecord):
    """
    Settings of a tracker.

    Parameters
    ----------
    window : int
        Largest number of detections from which the position of a ball at rest is estimated.
    settled : int
        Number of detections at one place after which a ball counts as being at rest.
    lost_after : float
        Time without a detection after which the state of a ball is UNKNOWN [s].
    systematic_error : float
        Standard deviation of the errors of x and y that all pictures have in common, such as those
        of the calibration of the camera [m].

    """

    READ_ONLY: ClassVar = None  # as parameters of a node: all
    window: int = whole_number(minimum=10, maximum=10_000, default=60)
    settled: int = whole_number(minimum=2, maximum=5, default=5)
    lost_after: float = number('s', minimum=0.05, maximum=10.0, default=0.5)
    systematic_error: float = number('m', minimum=0.0, maximum=MAX_DEVIATION, default=0.0005)


@dataclass(slots=True, eq=False)
class _Track:
    """One ball: the window of its detections, and their last classes."""

    window: Array  # (n, 5): x, y [m], and xx, xy, yy of the covariance [m^2]
    kinds: deque[str]
    kind: str  # class that most of the last detections have
    last: deque[tuple[float, Place]] = field(default_factory=lambda: deque(maxlen=OF_VELOCITY))
    score: int = 0  # see `CONFIRMED`
    elsewhere: int = 0  # number of successive detections that contradict the resting place
    name: str = ''
    is_confirmed: bool = False
    is_pocketed: bool = False
    estimate: Place = (0.0, 0.0)

    @property
    def time(self) -> float:
        """Time of the last detection [s]."""
        return self.last[-1][0] if self.last else -math.inf

    def expected(self, time: float) -> Place:
        """Place at a time [s], if the ball goes on as it moved between its last two detections."""
        (before, (x0, y0)), (last, (x, y)) = (list(self.last) * 2)[-2:]
        if not last > before:
            return self.estimate
        ahead = (time - last) / (last - before)
        return x + ahead * (x - x0), y + ahead * (y - y0)


class BallTracker:
    """
    Estimates where the balls of a table lie; times are those of the detections [s].

    Parameters
    ----------
    radius : float
        Radius of a ball [m].
    settings : TrackerSettings
    pockets : (n, 3) array_like
        Centres of the pockets and their radii [m]. A ball that is lost as it rolls into a pocket
        counts as pocketed; every other lost ball is not seen.
    counts : mapping of str to int
        Largest number of balls of each class; of a class that is left out, 1.

    """

    def __init__(
        self,
        radius: float,
        settings: TrackerSettings = TrackerSettings(),
        pockets: Sequence[Sequence[float]] | NDArray[np.float64] = (),
        counts: Mapping[str, int] = ONE_CLASS,
    ) -> None:
        self._radius, self._settings, self._counts = radius, settings, counts
        self._gap = 2.0 * APART * radius  # smallest distance of detections of two balls [m]
        self._pockets = [tuple(map(float, each)) for each in pockets]
        self.time = 0.0  # of the last picture [s]; 0 if there was none
        self.reset()

    def reset(self) -> None:
        """Forget all balls."""
        self._tracks: list[_Track] = []
        self._names: dict[str, _Track] = {}
        self._kinds: dict[str, None] = {}  # classes that pictures have shown, in their order

    @property
    def pocketed(self) -> set[str]:
        """Names of the balls that have fallen into a pocket."""
        return {name for name, track in self._names.items() if track.is_pocketed}

    @property
    def surplus(self) -> list[str]:
        """Classes of balls that are seen at rest, but have no name: their class has none left."""
        unnamed = (track for track in self._tracks if not track.name)
        return [
            track.kind
            for track in unnamed
            if len(track.window) == self._settings.window and not self._is_lost(track, self.time)
        ]

    def update(self, detections: Sequence[Detection], time: float) -> None:
        """Take the detections of one picture, which was taken at `time` [s]; there may be none."""
        if time != self.time:  # messages of one time are one picture
            for track in self._tracks:
                track.score -= track.time != self.time
        self._kinds |= dict.fromkeys(each.kind for each in detections)
        places = np.array([each.position for each in detections]).reshape(-1, 2)
        gaps = np.hypot(*(places[:, np.newaxis] - places).T)
        is_doubled = (gaps < self._gap).sum(axis=0) > 1
        taken = self._assign(detections, places, is_doubled, time)
        for track, k in taken.items():
            self._update(track, detections[k], time)
        others = (each for k, each in enumerate(detections) if k not in taken.values())
        for detection in others:
            if self._is_free(detection.position, time) and len(self._tracks) < MAX_BALLS:
                kinds = deque[str](maxlen=self._settings.window)
                self._tracks.append(_Track(_row(detection), kinds, detection.kind))
                self._see(self._tracks[-1], detection, time)
        self.time = max(self.time, time)
        self._drop(time)
        self._name(time)

    def balls(self, now: float) -> dict[str, Sighting]:
        """Balls that are on the table or not seen, by name, at the time `now` [s]."""
        found = {}
        for name, track in self._names.items():
            if not track.is_pocketed:
                xx, xy, yy = (track.window[:, 2:].mean(axis=0) / len(track.window)).tolist()
                found[name] = Sighting(
                    track.estimate,
                    (xx, xy, yy),
                    is_seen=not self._is_lost(track, now) and not self._is_covered(track),
                    is_moving=not self._is_resting(track),
                    time=track.time,
                    systematic_error=self._settings.systematic_error,
                )
        return found

    # --- detections -----------------------------------------------------------------------------

    def _assign(
        self,
        detections: Sequence[Detection],
        places: Array,
        is_doubled: NDArray[np.bool_],
        time: float,
    ) -> dict[_Track, int]:
        """Find the most likely detection of each track, which may have none."""
        tracks = [each for each in self._tracks if not each.is_pocketed and each.time != time]
        if not (tracks and detections):
            return {}
        lost = np.array([self._is_lost(track, time) for track in tracks])
        sure = np.array([track.is_confirmed for track in tracks])
        # A lost ball is found only where it was, and one that falls only on its way: other
        # detections of its class are more likely false. If they are not, a track begins.
        reach = MAX_SPEED * np.array([time - track.time for track in tracks])
        reach[lost | [track.time < self.time and self._falls(track) for track in tracks]] = 0.0
        expected = np.array([(track.estimate, track.expected(time)) for track in tracks])
        way = expected[:, :, np.newaxis] - places  # (tracks, 2, detections, 2)
        distance = np.hypot(way[..., 0], way[..., 1]).min(axis=1)
        jump = np.where(distance <= reach[:, np.newaxis], JUMP, IMPOSSIBLE)
        kinds = np.array([track.kind for track in tracks])
        is_wrong = kinds[:, np.newaxis] != np.array([each.kind for each in detections])
        cost = np.where(distance <= self._radius, distance / self._radius, jump + distance)
        doubt = np.where(lost, FOUND, np.where(sure, 0.0, NEW))
        cost += WRONG_CLASS * is_wrong + doubt[:, np.newaxis]
        cost -= np.where(is_doubled, DOUBLED, FALSE)
        none = np.where(sure & ~lost, NOT_DETECTED, 0.0)
        choices = np.hstack([cost, np.repeat(none[:, np.newaxis], len(tracks), axis=1)])
        rows, columns = linear_sum_assignment(choices)
        pairs = zip(rows.tolist(), columns.tolist(), strict=True)
        return {tracks[i]: k for i, k in pairs if k < len(detections)}

    def _update(self, track: _Track, detection: Detection, time: float) -> None:
        """Take the detection of a track; a resting ball moves only after several of them."""
        row = _row(detection)
        is_far = math.dist(track.estimate, detection.position) > self._radius
        if self._is_resting(track) and (is_far or _differ(track.window, row)):
            track.elsewhere += 1
            if track.elsewhere >= ELSEWHERE:
                track.window, track.elsewhere = row, 0
        elif is_far:
            track.window = row
        else:
            track.elsewhere = 0
            track.window = np.vstack([track.window, row])[-self._settings.window :]
            self._cut(track)
        self._see(track, detection, time)

    def _see(self, track: _Track, detection: Detection, time: float) -> None:
        track.score += 1
        track.is_confirmed |= track.score >= CONFIRMED
        track.last.append((time, detection.position))
        track.kinds.append(detection.kind)
        is_resting = self._is_resting(track)
        while len(track.kinds) > MOVING_VOTES and not is_resting:
            track.kinds.popleft()
        # A moving ball is where it was detected last.
        place = track.window.mean(axis=0) if is_resting else track.window[-1]
        track.estimate = float(place[0]), float(place[1])

    def _cut(self, track: _Track) -> None:
        """Drop the detections from before a motion."""
        for part in (self._settings.settled, len(track.window) // 2):
            older, newer = track.window[:-part], track.window[-part:]
            if part and len(older) and _differ(older, newer):
                # The rest may still contain the motion: it counts as rest only after it has grown.
                track.window = newer[-(self._settings.settled - 1) :]
                return

    def _drop(self, time: float) -> None:
        """Find balls that have been pocketed; drop lost tracks without a name, and false ones."""
        kept = []
        for track in self._tracks:
            is_lost = self._is_lost(track, time)
            if is_lost and track.name:
                track.is_pocketed |= self._falls(track)
            if track.name or (not is_lost and (track.is_confirmed or track.score >= 0)):
                kept.append(track)
        self._tracks = kept

    def _name(self, time: float) -> None:
        """Give each track a name of the class that most of its last detections have."""
        tracks = [track for track in self._tracks if track.is_confirmed]
        names = [(kind, name) for kind in self._kinds for name in self._names_of(kind)]
        votes = np.zeros((len(tracks), len(names)))
        for i, track in enumerate(tracks):
            counts = Counter(track.kinds)
            is_lost = self._is_lost(track, time)
            for k, (kind, name) in enumerate(names):
                # A ball keeps its name until another one that is seen has more votes for it.
                votes[i, k] = (track.name == name) / (2 * MAX_BALLS)
                if MIN_SHARE * len(track.kinds) <= counts[kind] and not is_lost:
                    votes[i, k] += counts[kind]
        self._names = {}
        for track in tracks:
            track.name = ''
        rows, columns = linear_sum_assignment(votes, maximize=True)
        for i, k in zip(rows, columns, strict=True):
            if votes[i, k]:
                tracks[i].kind, tracks[i].name = names[k]
                self._names[tracks[i].name] = tracks[i]

    def _names_of(self, kind: str) -> list[str]:
        """Names of the balls of a class; the name of another class is left out."""
        numbered = (f'{kind}_{number}' for number in count(2))
        others = (name for name in numbered if name not in self._kinds)
        return [kind, *islice(others, self._counts.get(kind, 1) - 1)]

    # --- conditions -----------------------------------------------------------------------------

    def _is_resting(self, track: _Track) -> bool:
        return len(track.window) >= self._settings.settled

    def _is_lost(self, track: _Track, time: float) -> bool:
        return time - track.time > self._settings.lost_after

    def _is_covered(self, track: _Track) -> bool:
        """Whether a picture since the last detection of a ball shows another ball at its place."""
        return any(
            other.time > track.time and math.dist(other.estimate, track.estimate) < self._gap
            for other in self._names.values()
        )

    def _is_free(self, place: Place, time: float) -> bool:
        """Whether a ball may be at a place [m]: not over a pocket, nor at a ball seen just now."""
        return not any(math.dist(place, (x, y)) <= size for x, y, size in self._pockets) and all(
            math.dist(place, track.last[-1][1]) >= self._gap
            for track in self._tracks
            if track.time == time
        )

    def _falls(self, track: _Track) -> bool:
        """Whether a ball that is seen no more has fallen into a pocket."""
        (begin, (x0, y0)), (end, (x, y)) = track.last[0], track.last[-1]
        if self._is_resting(track) or not end > begin:
            return False
        u, v = (x - x0) / (end - begin), (y - y0) / (end - begin)
        speed = math.hypot(u, v)
        way = min(BESIDE_HOLE + speed * BEFORE_FALL, speed**2 / (2.0 * ROLLING))
        for px, py, size in self._pockets:
            distance = math.hypot(px - x, py - y)
            if distance <= size + self._radius:
                return True  # in the jaws, where it may rattle
            toward = (px - x) * u + (py - y) * v
            aside = (px - x) * v - (py - y) * u
            if (
                toward > 0.0
                and abs(aside) <= (size + self._radius) * speed
                and distance - size <= way
            ):
                return True
        return False


def _row(detection: Detection) -> Array:
    return np.array([[*detection.position, *detection.covariance]])


def _differ(one: Array, other: Array) -> bool:
    """Whether the means of two groups of detections differ by more than their errors."""
    (x, y, *errors), (u, v, *others) = one.mean(axis=0).tolist(), other.mean(axis=0).tolist()
    dx, dy = u - x, v - y
    xx, xy, yy = (a / len(one) + b / len(other) for a, b in zip(errors, others, strict=True))
    # d^T C^-1 d, with the inverse of a symmetric matrix written out
    determinant = xx * yy - xy * xy
    return dx * dx * yy - 2.0 * dx * dy * xy + dy * dy * xx > CHANGE * determinant
