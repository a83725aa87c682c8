"""
Where the balls lie, from detections with errors, losses and wrong classes.

A track is one ball. Two balls are at least a diameter apart, so a detection belongs to the track
within a radius of it, whatever its class; only a detection far from all tracks is assigned by its
class. The class of a track is the one that most of its last detections have. A class has as many
balls as one picture has shown of it: the first has the name of the class, the second of the class
`solid` is `solid_2`, and so on.

While a ball rests, its position is the mean of a window of detections, and the covariance of the
mean falls as the window grows. Two tests for a change of the mean, with the newest detections and
with the newer half of the window, drop the detections from before a motion, so that the window
holds one resting place (windows that a test for change cuts: Bifet and Gavalda, "Learning from
time-changing data with adaptive windowing", SDM 2007).
"""

from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import count, islice
import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from billiard_shot.perception.gate import MAX_BALLS
from billiard_shot.perception.sightings import Sighting
from billiard_shot.records import Array
from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import number, whole_number
from billiard_shot.scene.rack import Place

CHANGE = 36.0
"""
Square of the distance, in standard deviations, beyond which two positions differ.

The errors in x and y being normal, the square exceeds it with a probability of exp(-18), 1.5e-8.
"""

ELSEWHERE = 3
"""Number of successive detections elsewhere after which a resting ball is taken to have moved."""

BEFORE_FALL = 0.1
"""Longest time from the last detection of a ball to its fall into a pocket [s]: three pictures."""

OF_VELOCITY = 4
"""Number of last detections that give the velocity of a ball."""


@dataclass(frozen=True, slots=True)
class Detection:
    """One ball that a camera has detected."""

    kind: str  # class of the ball; may be wrong
    position: Place  # centre, x and y in the frame `table`, m
    covariance: tuple[float, float, float]  # of the position: xx, xy, yy, m^2; not zero


@dataclass(frozen=True, slots=True)
class TrackerSettings:
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

    """

    READ_ONLY: ClassVar = None  # as parameters of a node: all
    window: int = whole_number(minimum=10, maximum=10_000, default=60)
    settled: int = whole_number(minimum=2, maximum=5, default=5)
    lost_after: float = number('s', minimum=0.05, maximum=10.0, default=0.5)

    def __post_init__(self) -> None:
        check(self)


@dataclass(slots=True, eq=False)
class _Track:
    """One ball: the window of its detections, and their last classes."""

    window: Array  # (n, 5): x, y [m], and xx, xy, yy of the covariance [m^2]
    kinds: deque[str]
    last: deque[tuple[float, Place]] = field(default_factory=lambda: deque(maxlen=OF_VELOCITY))
    elsewhere: list[Array] = field(default_factory=list)
    kind: str = ''  # class that most of the last detections have
    name: str = ''
    is_confirmed: bool = False  # whether it has ever been at rest or detected often
    is_pocketed: bool = False
    estimate: Place = (0.0, 0.0)

    @property
    def time(self) -> float:
        """Time of the last detection [s]."""
        return self.last[-1][0] if self.last else -math.inf


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

    """

    def __init__(
        self,
        radius: float,
        settings: TrackerSettings = TrackerSettings(),
        pockets: Sequence[Sequence[float]] | NDArray[np.float64] = (),
    ) -> None:
        self._radius, self._settings = radius, settings
        self._pockets = [tuple(map(float, each)) for each in pockets]
        self.time = 0.0  # of the last picture [s]; 0 if there was none
        self.reset()

    def reset(self) -> None:
        """Forget all balls."""
        self._tracks: list[_Track] = []
        self._names: dict[str, _Track] = {}
        self._counts: Counter[str] = Counter()  # by class, the most balls that a picture has shown

    @property
    def pocketed(self) -> set[str]:
        """Names of the balls that have fallen into a pocket."""
        return {name for name, track in self._names.items() if track.is_pocketed}

    def update(self, detections: Sequence[Detection], time: float) -> None:
        """Take the detections of one picture, which was taken at `time` [s]; there may be none."""
        self._counts |= Counter(each.kind for each in detections)
        for detection in self._assign_by_place(detections, time):
            track = self._missing(detection, time)
            if track is None:
                if len(self._tracks) == MAX_BALLS:
                    continue
                track = _Track(_row(detection), deque(maxlen=self._settings.window))
                self._tracks.append(track)
            elif self._is_resting(track) and not self._is_lost(track, time):
                self._see_elsewhere(track, _row(detection))
            else:
                track.window = _row(detection)
            self._see(track, detection, time)
        self.time = max(self.time, time)
        self._drop(time)
        self._name()

    def balls(self, now: float) -> dict[str, Sighting]:
        """Balls that are on the table or not seen, by name, at the time `now` [s]."""
        found = {}
        for name, track in self._names.items():
            if not track.is_pocketed:
                xx, xy, yy = (track.window[:, 2:].mean(axis=0) / len(track.window)).tolist()
                found[name] = Sighting(
                    track.estimate,
                    (xx, xy, yy),
                    is_seen=not self._is_lost(track, now),
                    is_moving=not self._is_resting(track),
                    time=track.time,
                )
        return found

    # --- assignment -----------------------------------------------------------------------------

    def _assign_by_place(self, detections: Sequence[Detection], time: float) -> list[Detection]:
        """Give each track the nearest detection within a radius; return those that are left."""
        pairs = sorted(
            (math.dist(track.estimate, detection.position), i, k)
            for i, track in enumerate(self._tracks)
            for k, detection in enumerate(detections)
        )
        taken: set[int] = set()
        for distance, i, k in pairs:
            track = self._tracks[i]
            if distance > self._radius:
                break
            if k in taken or track.time == time:
                continue
            taken.add(k)
            row = _row(detections[k])
            if self._is_resting(track) and _differ(track.window, row):
                self._see_elsewhere(track, row)
            else:
                track.elsewhere.clear()
                track.window = np.vstack([track.window, row])[-self._settings.window :]
                self._cut(track)
            self._see(track, detections[k], time)
        return [each for k, each in enumerate(detections) if k not in taken]

    def _missing(self, detection: Detection, time: float) -> _Track | None:
        """Find a ball that this picture has not shown yet, by the class of a detection."""

        def far(track: _Track) -> tuple[bool, float]:
            return self._is_resting(track), math.dist(track.estimate, detection.position)

        missing = (
            track
            for track in self._names.values()
            if track.kind == detection.kind and track.time != time
        )
        return min(missing, key=far, default=None)

    def _see(self, track: _Track, detection: Detection, time: float) -> None:
        track.last.append((time, detection.position))
        track.kinds.append(detection.kind)
        track.is_pocketed = False
        # A moving ball is where it was detected last.
        place = track.window.mean(axis=0) if self._is_resting(track) else track.window[-1]
        track.estimate = float(place[0]), float(place[1])
        track.is_confirmed |= len(track.kinds) >= self._settings.settled

    def _see_elsewhere(self, track: _Track, row: Array) -> None:
        """Keep a detection that contradicts a resting place; after some, the ball has moved."""
        track.elsewhere.append(row)
        if len(track.elsewhere) >= ELSEWHERE:
            track.window = row
            track.elsewhere.clear()

    def _cut(self, track: _Track) -> None:
        """Drop the detections from before a motion."""
        for part in (self._settings.settled, len(track.window) // 2):
            older, newer = track.window[:-part], track.window[-part:]
            if part and len(older) and _differ(older, newer):
                # The rest may still contain the motion: it counts as rest only after it has grown.
                track.window = newer[-(self._settings.settled - 1) :]
                return

    def _drop(self, time: float) -> None:
        """Drop lost tracks that were hardly ever seen, and find balls that have been pocketed."""
        lost = [track for track in self._tracks if self._is_lost(track, time)]
        for track in lost:
            track.is_pocketed |= not self._is_resting(track) and self._falls(track)
        self._tracks = [each for each in self._tracks if each.is_confirmed or each not in lost]

    def _name(self) -> None:
        """Give each track a name of the class that most of its last detections have."""
        tracks = [track for track in self._tracks if track.is_confirmed]
        names = [(kind, name) for kind in self._counts for name in self._names_of(kind)]
        votes = np.zeros((len(tracks), len(names)))
        for i, track in enumerate(tracks):
            counts = Counter(track.kinds)
            for k, (kind, name) in enumerate(names):
                if counts[kind]:  # in a tie a track keeps its name
                    votes[i, k] = counts[kind] + (track.name == name) / (2 * MAX_BALLS)
        rows, columns = linear_sum_assignment(votes, maximize=True)
        self._names = {}
        for i, k in zip(rows, columns, strict=True):
            if votes[i, k]:
                tracks[i].kind, tracks[i].name = names[k]
                self._names[tracks[i].name] = tracks[i]

    def _names_of(self, kind: str) -> list[str]:
        """Names of the balls of a class; the name of another class is left out."""
        numbered = (f'{kind}_{number}' for number in count(2))
        others = (name for name in numbered if name not in self._counts)
        return [kind, *islice(others, self._counts[kind] - 1)]

    # --- conditions -----------------------------------------------------------------------------

    def _is_resting(self, track: _Track) -> bool:
        return len(track.window) >= self._settings.settled

    def _is_lost(self, track: _Track, time: float) -> bool:
        return time - track.time > self._settings.lost_after

    def _falls(self, track: _Track) -> bool:
        """Whether the ball comes over the hole of a pocket soon, if it goes on as it moved."""
        (begin, (x0, y0)), (end, (x, y)) = track.last[0], track.last[-1]
        if not end > begin:
            return False
        u, v = (x - x0) / (end - begin), (y - y0) / (end - begin)
        for px, py, size in self._pockets:
            toward = (px - x) * u + (py - y) * v
            if toward > 0.0:
                time = min(toward / (u * u + v * v), BEFORE_FALL)
                if math.hypot(px - x - time * u, py - y - time * v) <= size:
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
