"""
What an effect is: something of the physics that a prediction simulates where it is called for.

Gates are where the simulation is, in compiled code, which leaves out what is not called for. Here
is, for each, what it decided in a shot and why; and what a scene's wishes do to the numbers that
the compiled code gets, so that an effect that is forced off costs it nothing either.
"""
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot import row as at
from billiard_shot.shot.model import Model
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.trajectory import Trajectory

AUTO, OFF, ON = 'auto', 'off', 'on'


@dataclass(frozen=True, slots=True)
class Effect:
    """A physical effect in one shot; `reason` is one line of plain text."""

    name: str
    simulated: bool
    reason: str
    wanted: bool  # whether scene, stroke and motion call for it; the scene may force it off


@dataclass(frozen=True, slots=True)
class Look:
    """What a gate may look at: scene, stroke and the motion that came of them."""

    scene: Scene
    stroke: Stroke
    tolerance: float  # m
    trajectory: Trajectory
    row: NDArray[np.float64]  # see row.py

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Of the ball after the strike (3,) [m/s]."""
        return self.row[at.VELOCITY]

    @property
    def spin(self) -> NDArray[np.float64]:
        """Of the ball after the strike (3,) [rad/s]."""
        return self.row[at.SPIN]

    def impulse(self, contact: int) -> NDArray[np.float64]:
        """Normal and two tangential impulses of tip (0) or table (1) in the strike (3,) [N s]."""
        return self.row[at.IMPULSE].reshape(2, 3)[contact]


class Seen(NamedTuple):
    """Whether an effect was simulated, and why or why not."""

    simulated: bool
    reason: str


class Gate(ABC):
    """One effect. The methods look at nothing but their arguments."""

    name: ClassVar[str]
    needs: ClassVar[str]  # what it takes to be simulated, in a few words

    @abstractmethod
    def seen(self, look: Look) -> Seen:
        """Say whether it was simulated in a shot, and what of scene, stroke or motion decided."""

    @abstractmethod
    def off(self, model: Model) -> Model:
        """Take it out of the numbers for the compiled code."""

    def on(self, model: Model) -> Model:
        """Make it certain to be simulated; as it is, where there is nothing to decide."""
        return model


def report(gate: Gate, look: Look, again: Callable[[Scene], Look]) -> Effect:
    """
    Say what became of an effect in a shot.

    Parameters
    ----------
    gate : Gate
    look : Look
        At the shot.
    again : callable
        Predicts the same stroke in another scene: in this one, but with the effect left to its
        gate where the scene forces it on or off.

    """
    simulated, reason = gate.seen(look)
    wish = getattr(look.scene.effects, gate.name)
    nothing_to_decide = wish == ON and type(gate).on is Gate.on
    if wish == AUTO or nothing_to_decide:
        return Effect(gate.name, simulated, reason, simulated)
    effects = replace(look.scene.effects, **{gate.name: AUTO})
    wanted, reason = gate.seen(again(replace(look.scene, effects=effects)))
    if wish == ON:
        return Effect(gate.name, simulated, f'the scene turns it on; {reason}', wanted)
    word = 'it would be simulated' if wanted else 'nothing calls for it either'
    return Effect(gate.name, False, f'the scene turns it off; {word}: {reason}', wanted)
