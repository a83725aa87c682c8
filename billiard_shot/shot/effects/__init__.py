"""Effects: what is simulated where scene, stroke and motion call for it, one object each."""

from functools import lru_cache
from typing import Any

from billiard_shot.scene import Scene
from billiard_shot.shot.effects.context import ShotContext
from billiard_shot.shot.effects.friction import TableFriction, TipFriction
from billiard_shot.shot.effects.strike import (
    DoubleHit,
    EndMass,
    Shaft,
    TableContact,
    TipCurvature,
    TipSpring,
)
from billiard_shot.shot.strike_model import strike_model, StrikeModel
from billiard_shot.table.effects import (
    apply_overrides,
    check_overrides,
    Effect,
    EffectGate,
    TABLE_GATES,
)

__all__ = [
    'Effect',
    'GATES',
    'ShotContext',
    'model_of',
]

STRIKE_GATES: tuple[EffectGate[ShotContext], ...] = (
    TableContact(),
    TipFriction(),
    TableFriction(),
    Shaft(),
    TipSpring(),
    EndMass(),
    TipCurvature(),
    DoubleHit(),
)
check_overrides(STRIKE_GATES, StrikeModel)
GATES: tuple[EffectGate[Any], ...] = (*STRIKE_GATES[:-1], *TABLE_GATES, STRIKE_GATES[-1])


@lru_cache(maxsize=64)
def model_of(scene: Scene) -> StrikeModel:
    """Collect the numbers of a scene, with the effects that it forces on or off."""
    model = apply_overrides(strike_model(scene), STRIKE_GATES, scene.effects)
    return model._replace(surface=apply_overrides(model.surface, TABLE_GATES, scene.effects))
