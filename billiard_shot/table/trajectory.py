"""The motion of one ball, as people use it: its state at any time, its segments and events."""
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.table.motion import (
    ACCELERATION,
    ANGULAR,
    ANGULAR_ACCELERATION,
    CAUSE,
    Cause,
    COLUMNS,
    MOTION,
    Motion,
    POSITION,
    TIME,
    VELOCITY,
)


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
    """What happens where one segment meets the next."""

    BOUNCE = 'bounce'
    LAND = 'land'  # comes down to the cloth and stays on it
    ROLL = 'roll'  # stops slipping
    SPIN = 'spin'  # stands still, but for the spin about the vertical
    SPIN_END = 'spin_end'  # the spin about the vertical is used up; slides or rolls on
    REST = 'rest'
    BALL = 'ball'  # meets another ball
    CUSHION = 'cushion'
    CLUSTER = 'cluster'  # an impact of more than two bodies
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
    rows : (n, COLUMNS) float array
        Segments as in motion.py.

    """

    rows: NDArray[np.float64]

    def __post_init__(self) -> None:
        if self.rows.ndim != 2 or self.rows.shape[1] != COLUMNS or len(self.rows) == 0:
            raise ValueError(
                f'rows: shape {self.rows.shape} is not allowed; it must be (n, {COLUMNS}), n > 0'
            )
        self.rows.flags.writeable = False

    @property
    def rests(self) -> bool:
        """Whether the ball comes to rest, on the table, in a pocket or off it."""
        return self.rows[-1, MOTION] in (Motion.REST, Motion.POCKETED, Motion.OFF_TABLE)

    @property
    def duration(self) -> float:
        """Time at which the ball rests or, if it never does, its last motion begins [s]."""
        return float(self.rows[-1, TIME])

    @property
    def rest(self) -> NDArray[np.float64]:
        """Centre of the ball at `duration` (3,) [m]."""
        return self.rows[-1, POSITION:VELOCITY]

    def at(self, time: ArrayLike) -> BallState:
        """
        State at one time or many [s].

        Before 0 it is the one at 0. At the time of an event it is the one just after it. A ball
        that never rests keeps its last motion.
        """
        t = np.asarray(time, dtype=float)
        if not np.isfinite(t).all():
            raise ValueError(f'time: {time!r} is not allowed; it must be finite (s)')
        t = np.clip(t, 0.0, self.duration if self.rests else None)
        index = np.searchsorted(self.rows[:, TIME], t, side='right') - 1
        row = self.rows[index]
        dt = (t - row[..., TIME])[..., np.newaxis]
        velocity = row[..., VELOCITY:ACCELERATION]
        acceleration = row[..., ACCELERATION:ANGULAR]
        spin = row[..., ANGULAR:ANGULAR_ACCELERATION]
        return BallState(
            position=row[..., POSITION:VELOCITY] + (velocity + 0.5 * acceleration * dt) * dt,
            velocity=velocity + acceleration * dt,
            spin=spin + row[..., ANGULAR_ACCELERATION:CAUSE] * dt,
            motion=row[..., MOTION].astype(np.uint8),
        )

    @cached_property
    def segments(self) -> tuple[Segment, ...]:
        """Segments in order of time, the last one endless."""
        ends = [*self.rows[1:, TIME].tolist(), np.inf]
        return tuple(
            Segment(
                float(row[TIME]), end, Motion(int(row[MOTION])), row[POSITION:VELOCITY],
                row[VELOCITY:ACCELERATION], row[ACCELERATION:ANGULAR],
                row[ANGULAR:ANGULAR_ACCELERATION], row[ANGULAR_ACCELERATION:CAUSE],
            )
            for row, end in zip(self.rows, ends, strict=True)
        )

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Events in order of time."""
        return tuple(self._events())

    def _events(self) -> Iterator[Event]:
        causes = [Cause(int(code)) for code in self.rows[1:, CAUSE]]
        for (before, after), cause in zip(pairwise(self.segments), causes, strict=True):
            for kind in kinds_of(before.motion, after.motion, cause):
                yield Event(after.start, kind, after.position)


def kinds_of(before: Motion, after: Motion, cause: Cause) -> Iterator[EventKind]:
    """Tell what happened between two segments."""
    if cause != Cause.OWN:
        yield EventKind(cause.name.lower())
        return
    if before == Motion.FLIGHT:
        yield EventKind.BOUNCE if after == Motion.FLIGHT else EventKind.LAND
    elif after == before:
        yield EventKind.SPIN_END
    if after != before and after.name.lower() in list(EventKind):
        yield EventKind(after.name.lower())
