"""Effects: what is simulated where scene, stroke and motion call for it, one object each."""
from collections.abc import Callable

from billiard_shot.scene import Scene
from billiard_shot.shot.effects.air import Bounce, Flight
from billiard_shot.shot.effects.cloth import Roll, Slide, SpinDecay
from billiard_shot.shot.effects.effect import Effect, Gate, Look, OFF, ON, report
from billiard_shot.shot.effects.friction import TableFriction, TipFriction
from billiard_shot.shot.effects.strike import EndMass, TableContact, TipCurvature
from billiard_shot.shot.model import Model, numbers_of

__all__ = ['Effect', 'Gate', 'GATES', 'Look', 'effects_of', 'effects_of_nothing', 'model_of']

GATES: tuple[Gate, ...] = (
    TableContact(), TipFriction(), TableFriction(), EndMass(), TipCurvature(),
    Flight(), Bounce(), Slide(), Roll(), SpinDecay(),
)


def model_of(scene: Scene) -> Model:
    """Collect the numbers of a scene, with the effects that it forces on or off."""
    model = numbers_of(scene)
    for gate in GATES:
        wish = getattr(scene.effects, gate.name)
        if wish == OFF:
            model = gate.off(model)
        elif wish == ON:
            model = gate.on(model)
    return model


def effects_of(look: Look, again: Callable[[Scene], Look]) -> tuple[Effect, ...]:
    """Say of every effect whether it was simulated, and why; see `report`."""
    return tuple(report(gate, look, again) for gate in GATES)


def effects_of_nothing() -> tuple[Effect, ...]:
    """Say that no effect was simulated, because the stroke was not played."""
    return tuple(Effect(gate.name, False, 'the stroke was not played', False) for gate in GATES)
