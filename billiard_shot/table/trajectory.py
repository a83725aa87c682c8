"""The motion of one ball, as people use it: its state at any time, its segments and events."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.table import motion
from billiard_shot.table.motion import Cause, Motion


@dataclass(frozen=True, slots=True, eq=False)
class BallState:
    """
    State of a ball; at many times, all arrays have the axes of the times in front.

    Parameters
    ----------
    position : (..., 3) array_like
        Centre [m].
    velocity : (..., 3) array_like
        [m/s].
    spin : (..., 3) array_like
        [rad/s].
    motion : (...) uint8 array
        A `Motion`; what a ball that is given to `simulate` does follows from the rest.

    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    spin: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    motion: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((), np.uint8))

    def __repr__(self) -> str:
        if np.ndim(self.motion) > 0 or np.ndim(self.position) != 1:
            return f'BallState(at {np.shape(self.motion)} times)'
        vectors = (
            f'{name}={_rounded(getattr(self, name))}' for name in ('position', 'velocity', 'spin')
        )
        motion = f', {Motion(int(self.motion)).name}' if self.motion else ''
        return f'BallState({", ".join(vectors)}{motion})'


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A stretch of one kind of motion at constant acceleration, [start, end] in s."""

    start: float
    end: float  # inf: endless
    motion: Motion
    position: NDArray[np.float64]  # the rest: at the start, in m, s and rad
    velocity: NDArray[np.float64]
    acceleration: NDArray[np.float64]
    spin: NDArray[np.float64]
    angular_acceleration: NDArray[np.float64]


class EventKind(StrEnum):
    """
    What happens where one segment meets the next.

    Values are names in `Cause` or `Motion`, but for BOUNCE, LAND and SPIN_END.
    """

    BOUNCE = 'bounce'
    LAND = 'land'  # comes down to the cloth and stays on it
    ROLL = 'roll'  # stops slipping
    SPIN = 'spin'  # stands still, but for the spin about the vertical
    SPIN_END = 'spin_end'  # the spin about the vertical is used up; slides or rolls on
    REST = 'rest'
    BALL = 'ball'  # meets another ball
    CUSHION = 'cushion'
    CLUSTER = 'cluster'  # an impact of more than two bodies
    CUE = 'cue'  # the cue hits it again
    POCKET = 'pocket'
    OFF = 'off'  # leaves the table


@dataclass(frozen=True, slots=True, eq=False)
class Event:
    """Something that happens to the ball at a time [s], its centre at a position [m]."""

    time: float
    kind: EventKind
    position: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Trajectory:
    """
    Motion of one ball from time 0 on, exact between its events.

    Parameters
    ----------
    rows : (n,) array of motion.Segment, n > 0

    """

    rows: NDArray[np.void]

    def __repr__(self) -> str:
        last = _rounded(self.final_position[:2])
        rest = f'rests at {last} m' if self.comes_to_rest else 'never rests'
        return f'Trajectory(segments: {len(self.rows)}, {self.duration:.3g} s, {rest})'

    def __post_init__(self) -> None:
        dtype: np.dtype[np.void] = motion.SegmentRecord.dtype  # type: ignore[attr-defined]
        if self.rows.ndim != 1 or self.rows.dtype != dtype or len(self.rows) == 0:
            raise ValueError(
                f'rows must be segments (n,), n > 0, got {self.rows.dtype} {self.rows.shape}'
            )
        self.rows.flags.writeable = False

    @property
    def comes_to_rest(self) -> bool:
        """Whether the ball comes to rest, on the table, in a pocket or off it."""
        return self.rows['motion'][-1] in (Motion.REST, Motion.POCKETED, Motion.OFF_TABLE)

    @property
    def duration(self) -> float:
        """Time at which the ball rests or, if it never does, its last segment begins [s]."""
        return float(self.rows['time'][-1])

    @property
    def final_position(self) -> NDArray[np.float64]:
        """Centre of the ball at `duration` (3,) [m]."""
        last: NDArray[np.float64] = self.rows['position'][-1]
        return last

    def at(self, time: ArrayLike) -> BallState:
        """
        State at one time or many [s].

        Before 0 it is the one at 0. At the time of an event it is the one just after it. A ball
        that never rests keeps its last motion.
        """
        try:
            t = np.asarray(time, dtype=float)
        except (TypeError, ValueError, OverflowError):
            t = np.array(np.nan)
        if not np.isfinite(t).all():
            raise ValueError(f'time must be finite, got {time!r} (s)')
        t = np.clip(t, 0.0, self.duration if self.comes_to_rest else None)
        times = self.rows['time']
        index = np.searchsorted(times, t, side='right') - 1
        dt = (t - times[index])[..., np.newaxis]
        velocity, acceleration = self.rows['velocity'][index], self.rows['acceleration'][index]
        return BallState(
            position=self.rows['position'][index] + (velocity + 0.5 * acceleration * dt) * dt,
            velocity=velocity + acceleration * dt,
            spin=self.rows['spin'][index] + self.rows['spin_acceleration'][index] * dt,
            motion=self.rows['motion'][index].astype(np.uint8),
        )

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        """Segments in order of time, the last one endless."""
        rows = self.rows
        times = rows['time'].tolist()
        return tuple(
            Segment(begin, end, Motion(kind), *vectors)
            for begin, end, kind, *vectors in zip(
                times,
                [*times[1:], np.inf],
                rows['motion'].tolist(),
                rows['position'],
                rows['velocity'],
                rows['acceleration'],
                rows['spin'],
                rows['spin_acceleration'],
                strict=True,
            )
        )

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Events in order of time."""
        return tuple(self._events())

    def _events(self) -> Iterator[Event]:
        causes = map(Cause, self.rows['cause'][1:].tolist())
        for (before, after), cause in zip(pairwise(self.segments), causes, strict=True):
            for kind in kinds_of(before.motion, after.motion, cause):
                yield Event(after.start, kind, after.position)


def _rounded(vector: ArrayLike) -> str:
    """Format a vector with four digits, as in (0.118, -0.175)."""
    # + 0.0 makes 0 of -0
    return f'({", ".join(f"{round(each, 4) + 0.0:.4g}" for each in np.asarray(vector).tolist())})'


def kinds_of(before: Motion, after: Motion, cause: Cause) -> Iterator[EventKind]:
    """Tell what happened between two segments."""
    if cause not in (Cause.OWN, Cause.RELEASE, Cause.ROLL_ON):
        yield EventKind(cause.name.lower())
        return
    if after == before:
        if cause == Cause.OWN:
            yield EventKind.BOUNCE if after == Motion.FLIGHT else EventKind.SPIN_END
        return
    if before == Motion.FLIGHT:
        yield EventKind.LAND
    if after.name.lower() in list(EventKind):
        yield EventKind(after.name.lower())
