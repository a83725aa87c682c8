"""
Models of the cushion: how a ball that lies on the cloth leaves it.

The default is `mathavan` (rebound.py), which balls in the air meet in any case. Another model is a
function, a number and a name here, and its defaults in `CUSHIONS` (scene/table.py).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from billiard_shot.compiled import inner, innermost
from billiard_shot.table.ball_impact import collide_fixed

if TYPE_CHECKING:
    from billiard_shot.table.geometry import TableModel, TableNumbers
    from billiard_shot.table.motion import BallRecord

MATHAVAN, HAN = 0, 1
CUSHION_MODELS = {'mathavan': MATHAVAN, 'han': HAN}
LEAST_RESTITUTION = 0.05  # that of scenes


@innermost
def restitution_at(n: TableNumbers, ball: BallRecord, x: float, y: float, z: float) -> float:
    """Restitution of a cushion with the normal (x, y, z) for a ball as fast as this one."""
    speed = abs(x * ball.velocity[0] + y * ball.velocity[1] + z * ball.velocity[2])
    late, early = n.cushion_fading * speed, n.cushion_early_fading * speed
    return max(n.cushion_restitution / (1.0 + early + late * late), LEAST_RESTITUTION)


@inner
def change_velocity(table: TableModel, ball: BallRecord, x: float, y: float, z: float) -> None:
    """Change velocity and spin of a ball at a cushion with the normal (x, y, z) by its model."""
    if table.numbers.cushion_model == HAN:
        collide_han(table, ball, x, y, z)


@inner
def collide_han(table: TableModel, ball: BallRecord, x: float, y: float, z: float) -> None:
    """Let a ball collide with a cushion as if there were no cloth (Han 2005)."""
    restitution = restitution_at(table.numbers, ball, x, y, z)
    collide_fixed(
        table.params, ball, x, y, z, restitution, friction=table.numbers.cushion_friction
    )


@inner
def collide_lying(table: TableModel, ball: BallRecord, x: float, y: float, z: float) -> float:
    """
    Write how a lying ball leaves a cushion whose normal is (x, y, z), by a model in closed form.

    Velocity and spin after the contact are its `exit_velocity` and `exit_spin`. Return the way
    along the cushion during the contact [m].
    """
    v, w = ball.velocity, ball.spin
    vx, vy, wx, wy, wz = v[0], v[1], w[0], w[1], w[2]
    change_velocity(table, ball, x, y, z)
    for i in range(3):
        ball.exit_velocity[i], ball.exit_spin[i] = v[i], w[i]
    ball.exit_velocity[2] = 0.0  # the cloth holds it
    along = (x * (vy + v[1]) - y * (vx + v[0])) / math.sqrt(x * x + y * y)
    v[0], v[1], v[2], w[0], w[1], w[2] = vx, vy, 0.0, wx, wy, wz
    return 0.5 * table.numbers.cushion_duration * along
