"""
A ball against one other body: the impact in closed form.

At a ball's surface an impulse P along the normal changes only the normal velocity, one along the
surface only the slip, by the same response A in every direction. So the slip keeps its direction,
and Coulomb's friction takes mu P along it, or s / A if that already stops it, whatever the law of
restitution: the special case of billiard_shot.impact that Han (2005) works out for cushions.
"""

import math

from billiard_shot.compiled import inner, innermost
from billiard_shot.table.model.geometry import BallClothParams
from billiard_shot.table.model.motion import BallRecord

# Bodies that meet more slowly [m/s] stay together. If their motion on the cloth presses them
# together, they would meet ever more often, so they are set apart by a micrometre
# (event_loop.py).
MIN_APPROACH_SPEED = 1e-3


@innermost
def slip_at(
    ball: BallRecord, lever: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Tangential velocity [m/s] of a ball's surface at `lever` times the unit vector (x, y, z)."""
    v, w = ball.velocity, ball.spin
    along = v[0] * x + v[1] * y + v[2] * z
    return (
        v[0] - along * x + lever * (w[1] * z - w[2] * y),
        v[1] - along * y + lever * (w[2] * x - w[0] * z),
        v[2] - along * z + lever * (w[0] * y - w[1] * x),
    )


@innermost
def friction_impulse_per_slip(
    params: BallClothParams, push: float, slip: float, friction: float, balls: float
) -> float:
    """Friction's impulse per slip [kg], against it, when a number of balls meet at a point."""
    response = balls * (1.0 / params.mass + params.radius * params.radius / params.inertia)
    return min(friction * push / slip, 1.0 / response) if slip > 0.0 else 0.0


@innermost
def apply_impulse(
    params: BallClothParams,
    ball: BallRecord,
    lever: float,
    x: float,
    y: float,
    z: float,
    u: float,
    v: float,
    w: float,
) -> None:
    """Give a ball an impulse (u, v, w) [N s] at `lever` times the unit vector (x, y, z)."""
    turn = lever / params.inertia
    ball.velocity[0] += u / params.mass
    ball.velocity[1] += v / params.mass
    ball.velocity[2] += w / params.mass
    ball.spin[0] += turn * (y * w - z * v)
    ball.spin[1] += turn * (z * u - x * w)
    ball.spin[2] += turn * (x * v - y * u)


@inner
def collide_fixed(
    params: BallClothParams,
    ball: BallRecord,
    x: float,
    y: float,
    z: float,
    restitution: float,
    friction: float,
) -> None:
    """Let a ball collide with a fixed body, whose unit normal is (x, y, z)."""
    approach = -(ball.velocity[0] * x + ball.velocity[1] * y + ball.velocity[2] * z)
    u, v, w = slip_at(ball, -params.radius, x, y, z)
    push = params.mass * (1.0 + restitution) * approach
    drag = friction_impulse_per_slip(params, push, math.sqrt(u * u + v * v + w * w), friction, 1.0)
    apply_impulse(
        params,
        ball,
        -params.radius,
        x,
        y,
        z,
        u=push * x - drag * u,
        v=push * y - drag * v,
        w=push * z - drag * w,
    )
