"""
Where the balls lie, from detections with errors, losses and wrong names.

A track is one ball. Two balls are at least a diameter apart, so a detection belongs to the track
within a radius of it, whatever its name; only a detection far from all tracks is assigned by its
name. The name of a track is the name that most of its last detections have.

While a ball rests, its position is the mean of a window of detections, and the covariance of the
mean falls as the window grows. Two tests for a change of the mean, with the newest detections and
with the newer half of the window, drop the detections from before a motion, so that the window
holds one resting place (windows that a test for change cuts: Bifet and Gavalda, "Learning from
time-changing data with adaptive windowing", SDM 2007).
"""

from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass, field
import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

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


@dataclass(frozen=True, slots=True)
class Detection:
    """One ball that a camera has detected."""

    name: str  # may be wrong
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
    """One ball: the window of its detections, and their last names."""

    window: Array  # (n, 5): x, y [m], and xx, xy, yy of the covariance [m^2]
    names: deque[str]
    time: float  # of the last detection [s]
    elsewhere: list[Array] = field(default_factory=list)
    is_confirmed: bool = False  # whether it has ever been at rest or detected often
    is_pocketed: bool = False
    estimate: Place = (0.0, 0.0)
    velocity: Place = (0.0, 0.0)  # m/s, between the last two detections; 0 at rest


class BallTracker:
    """
    Estimates where the balls of a table lie; times are those of the detections [s].

    Parameters
    ----------
    radius : float
        Radius of a ball [m].
    settings : TrackerSettings
    pockets : (n, 3) array_like
        Centres of the pockets and their radii [m]. A ball that is lost while it moves at a pocket
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
        self.reset()

    def reset(self) -> None:
        """Forget all balls."""
        self._tracks: list[_Track] = []
        self._names: dict[str, _Track] = {}
        self.time = 0.0  # of the last detection [s]; 0 if no ball was detected yet

    @property
    def pocketed(self) -> set[str]:
        """Names of the balls that have fallen into a pocket."""
        return {name for name, track in self._names.items() if track.is_pocketed}

    def update(self, detections: Sequence[Detection], time: float) -> None:
        """Take the detections of one picture, which was taken at `time` [s]."""
        left = self._assign_by_place(detections, time)
        for detection in left:
            track = self._names.get(detection.name)
            if track is None or track.time == time:
                track = self._begin(detection, time)
            elif self._is_resting(track) and not self._is_lost(track, time):
                self._see_elsewhere(track, _row(detection))
            else:
                track.window = _row(detection)
            self._see(track, detection.name, time)
        if detections:
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
            self._see(track, detections[k].name, time)
        return [each for k, each in enumerate(detections) if k not in taken]

    def _begin(self, detection: Detection, time: float) -> _Track:
        track = _Track(_row(detection), deque(maxlen=self._settings.window), time)
        self._tracks.append(track)
        return track

    def _see(self, track: _Track, name: str, time: float) -> None:
        before, elapsed = track.estimate, time - track.time
        track.time, track.is_pocketed = time, False
        track.names.append(name)
        # A moving ball is where it was detected last.
        rests = self._is_resting(track)
        place = track.window.mean(axis=0) if rests else track.window[-1]
        x, y = track.estimate = float(place[0]), float(place[1])
        track.velocity = (0.0, 0.0)
        if elapsed > 0.0 and not rests:
            track.velocity = (x - before[0]) / elapsed, (y - before[1]) / elapsed
        track.is_confirmed |= len(track.names) >= self._settings.settled

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
        kept = []
        for track in self._tracks:
            if self._is_lost(track, time):
                if not track.is_confirmed:
                    continue
                track.is_pocketed |= not self._is_resting(track) and self._is_at_pocket(track)
            kept.append(track)
        self._tracks = kept

    def _name(self) -> None:
        """Give each track the name that most of its last detections have, each name once."""
        tracks = [track for track in self._tracks if track.is_confirmed]
        names = sorted({name for track in tracks for name in track.names})
        votes = np.zeros((len(tracks), len(names)))
        for i, track in enumerate(tracks):
            for name, count in Counter(track.names).items():
                votes[i, names.index(name)] = count
        rows, columns = linear_sum_assignment(votes, maximize=True)
        self._names = {
            names[k]: tracks[i] for i, k in zip(rows, columns, strict=True) if votes[i, k]
        }

    # --- conditions -----------------------------------------------------------------------------

    def _is_resting(self, track: _Track) -> bool:
        return len(track.window) >= self._settings.settled

    def _is_lost(self, track: _Track, time: float) -> bool:
        return time - track.time > self._settings.lost_after

    def _is_at_pocket(self, track: _Track) -> bool:
        """Whether the ball comes to a pocket soon, if it goes on as it moved."""
        (x, y), (u, v) = track.estimate, track.velocity
        squared = u * u + v * v
        for px, py, size in self._pockets:
            along = ((px - x) * u + (py - y) * v) / squared if squared else 0.0
            time = min(max(along, 0.0), BEFORE_FALL)
            if math.hypot(px - x - time * u, py - y - time * v) <= size + 2.0 * self._radius:
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
