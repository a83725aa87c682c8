"""What a cushion does to a ball: by the model that the scene asks for, or an edge to a flier."""

import math

from billiard_shot.compiled import inner
from billiard_shot.table.ball_impact import collide_fixed
from billiard_shot.table.flight_boundary import edge_at
from billiard_shot.table.geometry import Table
from billiard_shot.table.mathavan import rebound
from billiard_shot.table.motion import Ball
from billiard_shot.table.params import MATHAVAN


@inner
def edge_contact(table: Table, ball: Ball, feature: int) -> tuple[float, float, float, bool]:
    """Find the normal where a ball touches a nose, facing or arc, and whether the ball lies."""
    n, radius = table.numbers, table.params.radius
    x, y, away = edge_at(table, feature, ball.position[0], ball.position[1])
    if ball.position[2] == radius:
        shift = n.nose_standoff - away  # rounding; or pressed in by its motion on the cloth
        ball.position[0] += shift * x
        ball.position[1] += shift * y
        flat = n.nose_standoff / radius
        return flat * x, flat * y, 1.0 - n.nose_height / radius, True
    z = ball.position[2] - n.nose_height
    distance = math.sqrt(away * away + z * z)
    if distance == 0.0:
        return x, y, 0.0, False
    return x * away / distance, y * away / distance, z / distance, False


@inner
def collide_cushion(
    table: Table, ball: Ball, lying: bool, x: float, y: float, z: float, restitution: float
) -> None:
    """Let a ball collide with a cushion whose normal, where they touch, is (x, y, z)."""
    n = table.numbers
    if lying and n.cushion_model == MATHAVAN and restitution > 0.0:
        flat = math.sqrt(x * x + y * y)
        collide_cushion_mathavan(table, ball, x / flat, y / flat, restitution)
    else:
        collide_fixed(table.params, ball, x, y, z, restitution, n.cushion_friction)
    if lying:
        ball.velocity[2] = 0.0  # the cloth holds it


@inner
def collide_cushion_mathavan(
    table: Table, ball: Ball, nx: float, ny: float, restitution: float
) -> None:
    """Let a lying ball collide with a cushion with the normal (nx, ny), by Mathavan's model."""
    params = table.params
    r = params.radius
    u, v = ball.velocity[0], ball.velocity[1]
    p, q = ball.spin[0], ball.spin[1]
    # x along the cushion is (-ny, nx), y into it (-nx, -ny)
    vx, vy, wx, wy, wz = rebound(
        nx * v - ny * u,
        -nx * u - ny * v,
        r * (nx * q - ny * p),
        -r * (nx * p + ny * q),
        r * ball.spin[2],
        (table.numbers.nose_height - r) / r,
        restitution,
        table.numbers.cushion_friction,
        min(params.sliding_friction, 1e3),
        params.mass * r * r / params.inertia,
    )
    ball.velocity[0] = -ny * vx - nx * vy
    ball.velocity[1] = nx * vx - ny * vy
    ball.spin[0] = (-ny * wx - nx * wy) / r
    ball.spin[1] = (nx * wx - ny * wy) / r
    ball.spin[2] = wz / r
