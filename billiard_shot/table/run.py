"""What happened on a table: every ball's trajectory, every event with its energies."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.scene.by_name import ByName
from billiard_shot.status import Status
from billiard_shot.table.motion import Cause, Motion, NOTHING
from billiard_shot.table.rolling_boundary import ARCS, FACINGS
from billiard_shot.table.trajectory import BallState, EventKind, kinds_of, Trajectory
from billiard_shot.table.words import event_in_words, place_in_words, plural

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
        members = self._events.balls()
        return tuple(
            event
            for row, balls, position in zip(rows.tolist(), members, positions, strict=True)
            for event in self._read(row, balls, position)
        )

    def _read(
        self, row: Sequence[Any], members: list[int], position: NDArray[np.float64]
    ) -> Iterator[TableEvent]:
        """Read an EventRecord, as a row of plain numbers."""
        time, cause, _, other, energy, energy_after, before, after = row
        balls = tuple(self.names[i] for i in members)
        place = ''
        if cause == Cause.POCKET:
            place = POCKET_NAMES[other]
        elif cause == Cause.CUSHION:
            place = cushion_name(other)
        for kind in kinds_of(Motion(before), Motion(after), Cause(cause)):
            yield TableEvent(time, kind, balls, place, position, energy, energy_after=energy_after)
            energy = energy_after  # all that is lost is booked to the first


def cushion_name(feature: int) -> str:
    """Name a straight nose, facing or arc of the cushions, by its number."""
    if feature < FACINGS:
        return NOSE_NAMES[feature]
    return f'jaw of {POCKET_NAMES[(feature - (FACINGS if feature < ARCS else ARCS)) // 2]}'
