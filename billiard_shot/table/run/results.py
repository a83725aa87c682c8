"""What happened on a table: the trajectory of each ball, the events, and their words."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.scene.fields import ByName
from billiard_shot.status import Status
from billiard_shot.table.model import motion
from billiard_shot.table.model.motion import Cause, Motion, NOTHING
from billiard_shot.table.motion.boundaries import ARCS, FACINGS


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
        return self.rows['motion'][-1] in (motion.REST, motion.POCKETED, motion.LEFT_TABLE)

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
        times, kinds = self.rows['time'].tolist(), map(Motion, self.rows['motion'].tolist())
        names = 'position', 'velocity', 'acceleration', 'spin', 'spin_acceleration'
        vectors = (self.rows[name] for name in names)
        return tuple(map(Segment, times, [*times[1:], np.inf], kinds, *vectors))

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Events in order of time."""
        causes = map(Cause, self.rows['cause'][1:].tolist())
        return tuple(
            Event(after.start, kind, after.position)
            for (before, after), cause in zip(pairwise(self.segments), causes, strict=True)
            for kind in kinds_of(before.motion, after.motion, cause)
        )


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


HAPPENS = {
    EventKind.BOUNCE: 'bounces',
    EventKind.LAND: 'lands',
    EventKind.ROLL: 'begins to roll',
    EventKind.SPIN: 'stands and spins',
    EventKind.SPIN_END: 'side spin is used up',
    EventKind.REST: 'rests',
    EventKind.BALL: 'meets',
    EventKind.CUSHION: 'meets a cushion',
    EventKind.CLUSTER: 'meets',
    EventKind.POCKET: 'falls into a pocket',
    EventKind.OFF: 'leaves the table',
    EventKind.CUE: 'is hit by the cue again',
}


def ball_in_words(name: str) -> str:
    """Name a ball: `cue` is the cue ball."""
    return 'cue ball' if name == 'cue' else name


def place_in_words(place: str) -> str:
    """Name a pocket or cushion, such as `foot left`."""
    return place.replace('_', ' ')


def event_in_words(kind: EventKind, balls: Iterable[str], place: str = '') -> str:
    """Say what happened, such as `cue ball meets 8` or `8 falls into a pocket: foot left`."""
    first, *others = map(ball_in_words, balls)
    text = f'{first} {HAPPENS[kind]}'
    if others:
        text += f' {", ".join(others)}'
    return f'{text}: {place_in_words(place)}' if place else text


def moment_in_words(time: float) -> str:
    """Say when a double hit happened [s], 0: during the strike."""
    return f'at {time:.3g} s' if time > 0.0 else 'during the strike'


def rounded(value: float, digits: int, sign: str = '') -> str:
    """Write a number with `digits` digits after the point; `sign` is `+` or empty."""
    return f'{round(value, digits) + 0.0:{sign}.{digits}f}'  # + 0.0 makes 0 of -0


def plural(number: int, thing: str) -> str:
    """Count things, as in `1 ball` or `3 balls`."""
    return f'{number} {thing}{"s" * (number != 1)}'


def count_in_words(statuses: NDArray[np.uint16], thing: str, miscues: NDArray[np.bool_]) -> str:
    """Count things by their status (n,): `2000 strokes: 1998 OK, 2 OFF_TABLE; 1 miscue`."""
    counts = Counter(statuses.tolist()).most_common()
    listed = ', '.join(f'{count} {Status(status).name}' for status, count in counts)
    told = f'; {plural(int(miscues.sum()), "miscue")}' if miscues.any() else ''
    return plural(len(statuses), thing) + (f': {listed}' if listed else '') + told


# Corners in the quadrants (+, +), (-, +), (-, -), (+, -) of (x, y), then the sides: the foot is at
# x > 0, left at y > 0.
POCKET_NAMES = ('foot_left', 'head_left', 'head_right', 'foot_right', 'side_left', 'side_right')
NOSE_NAMES = ('foot', 'head', 'left', 'right')


@dataclass(frozen=True, slots=True, eq=False)
class TableEvent:
    """
    Something that happens on the table.

    Attributes
    ----------
    time : float
        [s].
    kind : EventKind
    balls : tuple of str
        The balls that take part; the first one is the one that comes first in the scene's order.
    place : str
        The cushion (`foot`, `head`, `left`, `right`, or `jaw of` a pocket) or the pocket; else ''.
    position : (3,) float array
        Centre of the first ball [m].
    energy_before, energy_after : float
        Kinetic energy of these balls [J]; what a ball brings into a pocket or off the table is
        lost there.

    """

    time: float
    kind: EventKind
    balls: tuple[str, ...]
    place: str
    position: NDArray[np.float64]
    energy_before: float
    energy_after: float

    def __repr__(self) -> str:
        return f'TableEvent({self.time:.4g} s: {self})'

    def __str__(self) -> str:
        return event_in_words(self.kind, self.balls, self.place)

    @property
    def dissipated(self) -> float:
        """Kinetic energy lost in the event [J]."""
        return self.energy_before - self.energy_after


class EventLog(NamedTuple):
    """
    What happened on a table.

    Attributes
    ----------
    rows : (n,) array of Event
    participants : (m, 2) int array
        Number of an event that is an impact of several bodies, and a ball that took part in it.

    """

    rows: NDArray[np.void]
    participants: NDArray[np.int64]

    def balls(self) -> list[list[int]]:
        """Balls that took part in each event, in their order."""
        members: list[list[int]] = [[] for _ in range(len(self.rows))]
        for number, ball in self.participants.tolist():
            if number < len(members):
                members[number].append(ball)
        columns = (self.rows[name].tolist() for name in ('cause', 'ball', 'other'))
        for found, cause, ball, other in zip(members, *columns, strict=True):
            if cause == Cause.BALL:
                found += [ball, other]
            elif cause not in (Cause.CLUSTER, Cause.CUE):
                found.append(ball)
        return members


@dataclass(frozen=True, eq=False)
class TableRun:
    """A simulated table. Numbers are in SI units and the frame `table`."""

    names: tuple[str, ...]
    status: Status
    duration: float  # s until all balls rest, or the last endless motion begins
    wall_time: float  # s that the simulation took
    searches: int  # how many contacts were looked for
    _segments: NDArray[np.void] = field(repr=False)  # Segment
    _events: EventLog = field(repr=False)
    _places: NDArray[np.int64] = field(repr=False)  # (balls, 2) pocket, first ball met; or NOTHING
    jaws_met: int = 0  # rounded jaws that ball 0 met before another ball

    def __repr__(self) -> str:
        fallen = (f', {ball} into {place_in_words(to)}' for ball, to in self.pocketed.items())
        return (
            f'TableRun({self.status.name}, {plural(len(self.names), "ball")}, '
            f'{plural(len(self.events), "event")} in {self.duration:.3g} s{"".join(fallen)})'
        )

    @cached_property
    def balls(self) -> Mapping[str, Trajectory]:
        """Trajectory of every ball."""
        owner = self._segments['ball']
        order = np.argsort(owner, kind='stable')
        parts = np.split(
            self._segments[order], np.searchsorted(owner[order], range(1, len(self.names)))
        )
        return ByName(zip(self.names, map(Trajectory, parts), strict=True))

    def at(self, time: ArrayLike) -> dict[str, BallState]:
        """State of every ball at one time or many [s], as `Trajectory.at` gives it."""
        return ByName({name: ball.at(time) for name, ball in self.balls.items()})

    @cached_property
    def final_position(self) -> dict[str, NDArray[np.float64]]:
        """Final position of every ball (3,) [m], also of a pocketed or lost one."""
        return ByName({name: ball.final_position for name, ball in self.balls.items()})

    @property
    def places_left(self) -> dict[str, tuple[float, float]]:
        """Final places (x, y) [m] of the balls that are neither pocketed nor lost."""
        gone = {*self.pocketed, *self.off_table}
        return {
            name: (float(x), float(y))
            for name, (x, y, _) in self.final_position.items()
            if name not in gone
        }

    @cached_property
    def pocketed(self) -> dict[str, str]:
        """The balls that fell into pockets, in their order in time, and which ones."""
        events = [event for event in self.events if event.kind == EventKind.POCKET]
        return {event.balls[0]: event.place for event in events}

    @cached_property
    def off_table(self) -> tuple[str, ...]:
        """The balls that left the table, in the order of time."""
        return tuple(event.balls[0] for event in self.events if event.kind == EventKind.OFF)

    @cached_property
    def first_met(self) -> dict[str, str]:
        """The first ball that each one met, if it met any."""
        met = zip(self.names, self._places[:, 1].tolist(), strict=True)
        return {name: self.names[other] for name, other in met if other != NOTHING}

    @cached_property
    def events(self) -> tuple[TableEvent, ...]:
        """All events in the order in which they were simulated, which is that of time."""
        rows = self._events.rows
        positions = np.empty((len(rows), 3))
        for i, name in enumerate(self.names):
            its = rows['ball'] == i
            positions[its] = self.balls[name].at(rows['time'][its]).position
        found: list[TableEvent] = []
        for row, members, position in zip(
            rows.tolist(), self._events.balls(), positions, strict=True
        ):
            time, cause, _, other, energy, left, before, after = row
            balls = tuple(self.names[i] for i in members)
            place = place_of(cause, other)
            for kind in kinds_of(Motion(before), Motion(after), Cause(cause)):
                found.append(TableEvent(time, kind, balls, place, position, energy, left))
                energy = left  # all that is lost is booked to the first
        return tuple(found)


def place_of(cause: int, feature: int) -> str:
    """Name the pocket or cushion of an event; '' for other events."""
    if cause == Cause.POCKET:
        return POCKET_NAMES[feature]
    return cushion_name(feature) if cause == Cause.CUSHION else ''


def cushion_name(feature: int) -> str:
    """Name a straight nose, facing or arc of the cushions, by its number."""
    if feature < FACINGS:
        return NOSE_NAMES[feature]
    return f'jaw of {POCKET_NAMES[(feature - (FACINGS if feature < ARCS else ARCS)) // 2]}'
