"""What happened on a table: every ball's trajectory, every event with its energies."""
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.status import Status
from billiard_shot.table import world
from billiard_shot.table.motion import Cause, COLUMNS, Motion
from billiard_shot.table.rails import ARCS, FACINGS, NOTHING
from billiard_shot.table.trajectory import BallState, EventKind, kinds_of, Trajectory

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

    @property
    def dissipated(self) -> float:
        """Kinetic energy lost in the event [J]."""
        return self.energy_before - self.energy_after


@dataclass(frozen=True, eq=False)
class TableRun:
    """A simulated table. Numbers are in SI units and the frame `table`."""

    names: tuple[str, ...]
    status: Status
    duration: float  # s until all balls rest, or the last endless motion begins
    wall_time: float  # s that the simulation took
    searches: int  # how many contacts were looked for
    _segments: NDArray[np.float64] = field(repr=False)
    _events: NDArray[np.float64] = field(repr=False)
    _places: NDArray[np.int64] = field(repr=False)

    @cached_property
    def balls(self) -> Mapping[str, Trajectory]:
        """Trajectory of every ball."""
        owner = self._segments[:, COLUMNS]
        return {
            name: Trajectory(self._segments[owner == i, :COLUMNS])
            for i, name in enumerate(self.names)
        }

    def at(self, time: ArrayLike) -> dict[str, BallState]:
        """State of every ball at one time or many [s], as `Trajectory.at` gives it."""
        return {name: ball.at(time) for name, ball in self.balls.items()}

    @cached_property
    def rest(self) -> dict[str, NDArray[np.float64]]:
        """Where every ball ends (3,) [m]; one that is pocketed or off, where it was last seen."""
        return {name: ball.rest for name, ball in self.balls.items()}

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
        return tuple(event for row in self._events for event in self._read(row))

    def _read(self, row: NDArray[np.float64]) -> list[TableEvent]:
        cause = Cause(int(row[world.EVENT_CAUSE]))
        ball, other = int(row[world.EVENT_BALL]), int(row[world.EVENT_OTHER])
        time, mask = float(row[world.EVENT_TIME]), int(row[world.EVENT_BALLS])
        balls = tuple(name for i, name in enumerate(self.names) if mask >> i & 1)
        after, before = divmod(int(row[world.EVENT_MOTIONS]), 8)
        place = ''
        if cause == Cause.POCKET:
            place = POCKET_NAMES[other]
        elif cause == Cause.CUSHION:
            place = _cushion_name(other)
        position = self.balls[self.names[ball]].at(time).position
        events = []
        energy = float(row[world.BEFORE])
        for kind in kinds_of(Motion(before), Motion(after), cause):
            events.append(TableEvent(
                time, kind, balls, place, position, energy, float(row[world.AFTER])
            ))
            energy = float(row[world.AFTER])  # all that is lost is booked to the first
        return events


def _cushion_name(what: int) -> str:
    if what < FACINGS:
        return NOSE_NAMES[what]
    return f'jaw of {POCKET_NAMES[(what - (FACINGS if what < ARCS else ARCS)) // 2]}'
