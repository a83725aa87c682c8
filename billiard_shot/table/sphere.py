"""
A ball against one other body: the impact in closed form.

At a ball's surface an impulse P along the normal changes only the normal velocity, one along the
surface only the slip, by the same response A in every direction. So the slip keeps its direction,
and Coulomb's friction takes mu P along it, or s / A if that already stops it, whatever the law of
restitution: the special case of billiard_shot.impact that Han (2005) works out for cushions.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.motion import ANGULAR, VELOCITY
from billiard_shot.table.surface import Surface

# Bodies that meet more slowly [m/s] stay together. Where their motion on the cloth presses them
# together they would meet ever more often, so they are set apart by a micrometre (play.py).
LEAST_APPROACH = 1e-3


@fused
def slip_at(
    ball: NDArray[np.float64], lever: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """Tangential velocity of a ball's surface at `lever` times the unit vector (x, y, z)."""
    v, w = VELOCITY, ANGULAR
    along = ball[v] * x + ball[v + 1] * y + ball[v + 2] * z
    return (
        ball[v] - along * x + lever * (ball[w + 1] * z - ball[w + 2] * y),
        ball[v + 1] - along * y + lever * (ball[w + 2] * x - ball[w] * z),
        ball[v + 2] - along * z + lever * (ball[w] * y - ball[w + 1] * x),
    )


@fused
def drag_of(surface: Surface, push: float, slip: float, friction: float, balls: float) -> float:
    """Friction's impulse per slip [kg], against it, when a number of balls meet at a point."""
    response = balls * (1.0 / surface.mass + surface.radius**2 / surface.inertia)
    return min(friction * push / slip, 1.0 / response) if slip > 0.0 else 0.0


@fused
def push_ball(
    surface: Surface, ball: NDArray[np.float64], lever: float, x: float, y: float, z: float,
    u: float, v: float, w: float,
) -> None:
    """Give a ball an impulse (u, v, w) [N s] at `lever` times the unit vector (x, y, z)."""
    turn = lever / surface.inertia
    ball[VELOCITY] += u / surface.mass
    ball[VELOCITY + 1] += v / surface.mass
    ball[VELOCITY + 2] += w / surface.mass
    ball[ANGULAR] += turn * (y * w - z * v)
    ball[ANGULAR + 1] += turn * (z * u - x * w)
    ball[ANGULAR + 2] += turn * (x * v - y * u)


@fused
def strike_fixed(
    surface: Surface, ball: NDArray[np.float64], x: float, y: float, z: float,
    restitution: float, friction: float,
) -> None:
    """Let a ball strike a body that nothing moves, whose unit normal is (x, y, z)."""
    approach = -(ball[VELOCITY] * x + ball[VELOCITY + 1] * y + ball[VELOCITY + 2] * z)
    u, v, w = slip_at(ball, -surface.radius, x, y, z)
    push = surface.mass * (1.0 + restitution) * approach
    drag = drag_of(surface, push, np.sqrt(u * u + v * v + w * w), friction, 1.0)
    push_ball(
        surface, ball, -surface.radius, x, y, z,
        push * x - drag * u, push * y - drag * v, push * z - drag * w,
    )
