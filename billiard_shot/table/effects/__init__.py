"""Effects on the table: what is simulated where the motion calls for it, one object each."""

from functools import lru_cache

from billiard_shot.scene import Scene
from billiard_shot.table.effects.air import Bounce, Flight
from billiard_shot.table.effects.cloth import Roll, Slide, SpinDecay
from billiard_shot.table.effects.collisions import (
    BallBallEffect,
    Cluster,
    CushionEffect,
    PocketEffect,
    Throw,
)
from billiard_shot.table.effects.effect import (
    apply_overrides,
    check_overrides,
    Effect,
    EffectContext,
    EffectGate,
    GateDecision,
    OFF,
    ON,
    report,
)
from billiard_shot.table.params import BallClothParams, TableParams
from billiard_shot.table.scene_params import ball_cloth_params, table_params

__all__ = [
    'Effect',
    'EffectGate',
    'EffectContext',
    'OFF',
    'ON',
    'GateDecision',
    'TABLE_GATES',
    'check_overrides',
    'apply_overrides',
    'params_on_table',
    'report',
    'table_on',
]

TABLE_GATES: tuple[EffectGate[EffectContext], ...] = (
    Flight(),
    Bounce(),
    Slide(),
    Roll(),
    SpinDecay(),
    CushionEffect(),
    PocketEffect(),
    BallBallEffect(),
    Throw(),
    Cluster(),
)


check_overrides(TABLE_GATES, BallClothParams, TableParams)


@lru_cache(maxsize=64)
def params_on_table(scene: Scene) -> tuple[BallClothParams, TableParams]:
    """Collect the parameters of a scene's table, with the effects that it forces on or off."""
    return apply_overrides(ball_cloth_params(scene), TABLE_GATES, scene.effects), table_on(scene)


@lru_cache(maxsize=64)
def table_on(scene: Scene) -> TableParams:
    """Collect the parameters of a scene's table alone, without the ball's."""
    return apply_overrides(table_params(scene), TABLE_GATES, scene.effects)
