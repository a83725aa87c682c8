"""
What an effect is: something of the physics that is simulated where it is called for.

Gates are where the simulation is, in compiled code, which leaves out what is not called for. Here
is, for each effect, what the gate decided and why; and what a scene's wish changes in the numbers
that the compiled code gets, so that an effect that is forced off costs it nothing either.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Effects, Scene
from billiard_shot.table.motion import Motion
from billiard_shot.table.run import TableEvent, TableRun
from billiard_shot.table.trajectory import EventKind, Trajectory

AUTO, OFF, ON = 'auto', 'off', 'on'
N = TypeVar('N')
L = TypeVar('L', bound='Look', contravariant=True)


@dataclass(frozen=True, slots=True)
class Effect:
    """A physical effect in one shot; `reason` is one line of plain text."""

    name: str
    simulated: bool
    reason: str
    wanted: bool  # whether scene, stroke and motion call for it; the scene may force it off


@dataclass(frozen=True, slots=True)
class Look:
    """What a gate may look at: scene and motion. Other rooms add to it."""

    scene: Scene
    velocity: NDArray[np.float64]  # of the ball that is struck, at first (3,) [m/s]
    spin: NDArray[np.float64]  # (3,) [rad/s]
    trajectory: Trajectory  # of that ball
    table: TableRun | None  # all that happens on the table, if there is more than that ball
    struck_together: bool  # whether what the ball touched at first took part in the strike

    @property
    def trajectories(self) -> Mapping[str, Trajectory]:
        """Of all balls."""
        return self.table.balls if self.table else {'cue': self.trajectory}

    def that_do(self, motion: Motion) -> list[str]:
        """Names of the balls that are ever in a kind of motion."""
        return [
            name
            for name, ball in self.trajectories.items()
            if np.any(ball.rows['motion'] == motion)
        ]

    def events(self, *kinds: EventKind) -> list[TableEvent]:
        """Events of some kinds on the table, in the order of time."""
        return [
            event for event in (self.table.events if self.table else ()) if event.kind in kinds
        ]


class Seen(NamedTuple):
    """Whether an effect was simulated, and why or why not."""

    simulated: bool
    reason: str


class Gate(ABC, Generic[L]):
    """One effect. The methods look at nothing but their arguments."""

    name: ClassVar[str]
    needs: ClassVar[str]  # what it takes to be simulated, in a few words
    # What a wish changes in the numbers, by their names; `on` is missing where there is nothing
    # to decide: the effect is a part of the equations, and vanishes by itself.
    changes: ClassVar[Mapping[str, Mapping[str, Any]]]

    def force(self, numbers: N, wish: str) -> N:
        """Return numbers (a named tuple) as a wish changes them; other tuples have the rest."""
        changes = self.changes.get(wish, {})
        mine = {name: value for name, value in changes.items() if hasattr(numbers, name)}
        return numbers._replace(**mine) if mine else numbers  # type: ignore[attr-defined]

    @abstractmethod
    def seen(self, look: L) -> Seen:
        """Say whether it was simulated in a shot, and what of scene, stroke or motion decided."""


def check_changes(gates: Iterable[Gate[Any]], *kinds: type[tuple[Any, ...]]) -> None:
    """Raise TypeError if a gate changes a number that no kind of named tuple has."""
    names = {name for kind in kinds for name in kind._fields}  # type: ignore[attr-defined]
    for gate in gates:
        for wish, changes in gate.changes.items():
            unknown = sorted(set(changes) - names)
            if unknown:
                raise TypeError(
                    f'effect {gate.name}: {wish} changes {", ".join(unknown)}, which is not a '
                    f'number of {", ".join(kind.__name__ for kind in kinds)}'
                )


def forced(numbers: N, gates: Iterable[Gate[Any]], effects: Effects) -> N:
    """Numbers (a named tuple) for the compiled code, as a scene's wishes change them."""
    for gate in gates:
        wish = getattr(effects, gate.name)
        if wish != AUTO:
            numbers = gate.force(numbers, wish)
    return numbers


def report(gate: Gate[L], look: L, again: Callable[[Scene], L]) -> Effect:
    """
    Say what became of an effect in a shot.

    Parameters
    ----------
    gate : Gate
    look : Look
        At the shot.
    again : callable
        Predicts the same in another scene: in this one, but with the effect left to its gate
        where the scene forces it on or off.

    """
    simulated, reason = gate.seen(look)
    wish = getattr(look.scene.effects, gate.name)
    if wish == AUTO or (wish == ON and ON not in gate.changes):
        return Effect(gate.name, simulated, reason, simulated)
    effects = replace(look.scene.effects, **{gate.name: AUTO})
    wanted, reason = gate.seen(again(replace(look.scene, effects=effects)))
    if wish == ON:
        return Effect(gate.name, simulated, f'the scene turns it on; {reason}', wanted)
    word = 'it would be simulated' if wanted else 'nothing calls for it either'
    return Effect(gate.name, False, f'the scene turns it off; {word}: {reason}', wanted)
