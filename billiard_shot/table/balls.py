"""Two balls: when they meet, and what that does to them."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.first_contact import first_contact
from billiard_shot.table.furniture import Furniture
from billiard_shot.table.motion import ACCELERATION, POSITION, TIME, VELOCITY
from billiard_shot.table.sphere import drag_of, push_ball, slip_at
from billiard_shot.table.surface import Surface

OVERLAP = 1e-10  # m


@fused
def meeting(
    a: NDArray[np.float64], b: NDArray[np.float64], now: float, end: float, diameter: float
) -> float:
    """Time at which two balls meet, if they go on as they do until `end`; else inf."""
    s, t = now - a[TIME], now - b[TIME]
    c0, c1, c2, c3, c4 = -diameter * diameter, 0.0, 0.0, 0.0, 0.0
    for i in range(3):
        f, g = a[ACCELERATION + i], b[ACCELERATION + i]
        u, v = a[VELOCITY + i], b[VELOCITY + i]
        x = a[POSITION + i] - b[POSITION + i] + (u + 0.5 * f * s) * s - (v + 0.5 * g * t) * t
        v = u + f * s - v - g * t
        h = 0.5 * (f - g)
        c0 += x * x
        c1 += 2.0 * x * v
        c2 += v * v + 2.0 * x * h
        c3 += 2.0 * v * h
        c4 += h * h
    return now + first_contact(c0, c1, c2, c3, c4, end - now, 2.0 * diameter)


@fused
def normal_of(
    a: NDArray[np.float64], b: NDArray[np.float64]
) -> tuple[float, float, float, float]:
    """Find the unit vector from ball b to ball a, and the distance of their centres [m]."""
    x = a[POSITION] - b[POSITION]
    y = a[POSITION + 1] - b[POSITION + 1]
    z = a[POSITION + 2] - b[POSITION + 2]
    distance = np.sqrt(x * x + y * y + z * z)
    return x / distance, y / distance, z / distance, distance


@fused
def away(
    a: NDArray[np.float64], b: NDArray[np.float64], column: int, x: float, y: float, z: float
) -> float:
    """Component along (x, y, z) of a vector of ball a, against that of ball b."""
    return float(
        x * (a[column] - b[column]) + y * (a[column + 1] - b[column + 1])
        + z * (a[column + 2] - b[column + 2])
    )


@fused
def strike_each_other(
    surface: Surface, furniture: Furniture, a: NDArray[np.float64], b: NDArray[np.float64],
    restitution: float,
) -> None:
    """
    Change the velocities and spins of two equal balls that meet: restitution and friction.

    Friction after Alciatore (technical proof TP A.14): its coefficient depends on the slip.
    """
    x, y, z, distance = normal_of(a, b)
    overlap = 2.0 * surface.radius - distance
    if overlap > OVERLAP:  # pressed together by their motion on the cloth
        for i, n in enumerate((x, y, z)):
            a[POSITION + i] += 0.5 * overlap * n
            b[POSITION + i] -= 0.5 * overlap * n
    p, q, s = slip_at(a, -surface.radius, x, y, z)
    u, v, w = slip_at(b, surface.radius, x, y, z)
    u, v, w = p - u, q - v, s - w
    slip = np.sqrt(u * u + v * v + w * w)
    push = -0.5 * surface.mass * (1.0 + restitution) * away(a, b, VELOCITY, x, y, z)
    friction = furniture.friction_fast + furniture.friction_slow * np.exp(
        -furniture.friction_decay * slip
    )
    drag = drag_of(surface, push, slip, friction, 2.0)
    u, v, w = push * x - drag * u, push * y - drag * v, push * z - drag * w
    push_ball(surface, a, -surface.radius, x, y, z, u, v, w)
    push_ball(surface, b, surface.radius, x, y, z, -u, -v, -w)
