"""
What an effect is: something of the physics that is simulated where it is called for.

The compiled code simulates an effect only if the motion calls for it. A gate says afterwards, for
one effect, whether it was simulated and why. A scene may force an effect on or off: the gate then
overrides numbers that the compiled code gets, so an effect that is off costs nothing.
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
from billiard_shot.table.trajectory import EventKind

AUTO, OFF, ON = 'auto', 'off', 'on'
N = TypeVar('N')
L = TypeVar('L', bound='EffectContext', contravariant=True)


@dataclass(frozen=True, slots=True)
class Effect:
    """A physical effect in one shot; `reason` is one line of plain text."""

    name: str
    simulated: bool
    reason: str
    called_for: bool  # whether scene, stroke and motion call for it; the scene may force it off


@dataclass(frozen=True, slots=True)
class EffectContext:
    """What a gate decides by: scene and motion. The layer `shot` adds the stroke."""

    scene: Scene
    velocity: NDArray[np.float64]  # of the ball that is struck, at first (3,) [m/s]
    spin: NDArray[np.float64]  # (3,) [rad/s]
    run: TableRun  # of all balls, the struck one first
    struck_together: bool  # whether other balls or a cushion took part in the strike

    def that_do(self, motion: Motion) -> list[str]:
        """Names of the balls that are ever in a kind of motion."""
        return [
            name for name, ball in self.run.balls.items() if np.any(ball.rows['motion'] == motion)
        ]

    def events(self, *kinds: EventKind) -> list[TableEvent]:
        """Events of some kinds on the table, in the order of time."""
        return [event for event in self.run.events if event.kind in kinds]


class GateDecision(NamedTuple):
    """Whether an effect was simulated, and why or why not."""

    simulated: bool
    reason: str


class EffectGate(ABC, Generic[L]):
    """One effect. The methods depend on nothing but their arguments."""

    name: ClassVar[str]
    condition: ClassVar[str]  # what it takes to be simulated, in a few words
    # What a setting changes in the numbers, by their names; `on` is missing where there is nothing
    # to decide: the effect is a part of the equations, and vanishes by itself.
    overrides: ClassVar[Mapping[str, Mapping[str, Any]]]
    # Whether a shot without the effect tells, too, whether it calls for it.
    tells_without: ClassVar[bool] = False

    def apply(self, numbers: N, setting: str) -> N:
        """Return numbers (a named tuple) as a setting changes them; other tuples have the rest."""
        changes = self.overrides.get(setting, {})
        mine = {name: value for name, value in changes.items() if hasattr(numbers, name)}
        return numbers._replace(**mine) if mine else numbers  # type: ignore[attr-defined]

    @abstractmethod
    def evaluate(self, context: L) -> GateDecision:
        """Say whether it was simulated in a shot, and what of scene, stroke or motion decided."""


def check_overrides(gates: Iterable[EffectGate[Any]], *kinds: type[tuple[Any, ...]]) -> None:
    """Raise TypeError if a gate changes a number that no kind of named tuple has."""
    names = {name for kind in kinds for name in kind._fields}  # type: ignore[attr-defined]
    for gate in gates:
        for setting, changes in gate.overrides.items():
            unknown = sorted(set(changes) - names)
            if unknown:
                raise TypeError(
                    f'effect {gate.name}: {setting} changes {", ".join(unknown)}, which is not a '
                    f'number of {", ".join(kind.__name__ for kind in kinds)}'
                )


def apply_overrides(numbers: N, gates: Iterable[EffectGate[Any]], effects: Effects) -> N:
    """Numbers (a named tuple) for the compiled code, as a scene's settings change them."""
    for gate in gates:
        setting = getattr(effects, gate.name)
        if setting != AUTO:
            numbers = gate.apply(numbers, setting)
    return numbers


def report(gate: EffectGate[L], context: L, again: Callable[[Scene], L]) -> Effect:
    """
    Say what became of an effect in a shot.

    Parameters
    ----------
    gate : EffectGate
    context : EffectContext
        Of the shot.
    again : callable
        Predicts the same in another scene: in this one, but with the effect left to its gate
        where the scene forces it on or off.

    """
    simulated, reason = gate.evaluate(context)
    setting = getattr(context.scene.effects, gate.name)
    if setting == AUTO or (setting == ON and ON not in gate.overrides):
        return Effect(gate.name, simulated, reason, simulated)
    effects = replace(context.scene.effects, **{gate.name: AUTO})
    if not gate.tells_without:
        context = again(replace(context.scene, effects=effects))
    called_for, reason = gate.evaluate(context)
    if setting == ON:
        return Effect(gate.name, simulated, f'the scene turns it on; {reason}', called_for)
    word = 'it would be simulated' if called_for else 'nothing calls for it either'
    return Effect(gate.name, False, f'the scene turns it off; {word}: {reason}', called_for)
