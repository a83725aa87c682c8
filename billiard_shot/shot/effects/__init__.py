"""Effects: what is simulated where scene, stroke and motion call for it, one object each."""

from collections.abc import Callable
from typing import Any

from billiard_shot.scene import Scene
from billiard_shot.shot.effects.friction import TableFriction, TipFriction
from billiard_shot.shot.effects.look import ShotLook
from billiard_shot.shot.effects.strike import DoubleHit, EndMass, TableContact, TipCurvature
from billiard_shot.shot.model import strike_model, StrikeModel
from billiard_shot.table.effects import check_changes, Effect, forced, Gate, report, TABLE_GATES

__all__ = ['Effect', 'GATES', 'ShotLook', 'effects_of', 'effects_of_nothing', 'model_of']

STRIKE_GATES: tuple[Gate[ShotLook], ...] = (
    TableContact(),
    TipFriction(),
    TableFriction(),
    EndMass(),
    TipCurvature(),
)
check_changes(STRIKE_GATES, StrikeModel)
GATES: tuple[Gate[Any], ...] = (*STRIKE_GATES, *TABLE_GATES, DoubleHit())


def model_of(scene: Scene) -> StrikeModel:
    """Collect the numbers of a scene, with the effects that it forces on or off."""
    model = forced(strike_model(scene), STRIKE_GATES, scene.effects)
    return model._replace(surface=forced(model.surface, TABLE_GATES, scene.effects))


def effects_of(look: ShotLook, again: Callable[[Scene], ShotLook]) -> tuple[Effect, ...]:
    """Say of every effect whether it was simulated, and why; see `report`."""
    return tuple(report(gate, look, again) for gate in GATES)


def effects_of_nothing() -> tuple[Effect, ...]:
    """Say that no effect was simulated, because the stroke was not played."""
    return tuple(Effect(gate.name, False, 'the stroke was not played', False) for gate in GATES)
