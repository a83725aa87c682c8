"""Effects on the table: what is simulated where the motion calls for it, one object each."""
from billiard_shot.scene import Scene
from billiard_shot.table.effects.air import Bounce, Flight
from billiard_shot.table.effects.cloth import Roll, Slide, SpinDecay
from billiard_shot.table.effects.effect import (
    Effect,
    forced,
    Gate,
    Look,
    OFF,
    ON,
    report,
    Seen,
)
from billiard_shot.table.effects.meetings import BallBall, Cluster, Cushion, Pocket, Throw
from billiard_shot.table.furniture import Furniture
from billiard_shot.table.model import furniture_of, surface_of
from billiard_shot.table.surface import Surface

__all__ = [
    'Effect', 'Gate', 'Look', 'OFF', 'ON', 'Seen', 'TABLE_GATES', 'forced', 'numbers_on_table',
    'report',
]

TABLE_GATES: tuple[Gate[Look], ...] = (
    Flight(), Bounce(), Slide(), Roll(), SpinDecay(), Cushion(), Pocket(), BallBall(), Throw(),
    Cluster(),
)


def numbers_on_table(scene: Scene) -> tuple[Surface, Furniture]:
    """Collect the numbers of a scene's table, with the effects that it forces on or off."""
    return (
        forced(surface_of(scene), TABLE_GATES, scene.effects),
        forced(furniture_of(scene), TABLE_GATES, scene.effects),
    )
