"""What a cushion does to a ball: by the model that the scene asks for, or an edge to a flier."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.table.airborne import edge_at
from billiard_shot.table.furniture import Bed, Furniture, HAN
from billiard_shot.table.mathavan import bounce_of
from billiard_shot.table.motion import ANGULAR, CLIMB, HEIGHT, POSITION, VELOCITY
from billiard_shot.table.sphere import LEAST_APPROACH, restitution_at, strike_fixed
from billiard_shot.table.surface import Surface


@compiled
def strike_cushion(
    surface: Surface, furniture: Furniture, bed: Bed, ball: NDArray[np.float64], what: int,
    lying: bool,
) -> None:
    """Let a ball strike a nose, facing or arc."""
    nx, ny, away = edge_at(bed, what, ball[POSITION], ball[POSITION + 1])
    if lying:
        shift = bed.reach - away  # rounding; or pressed in by its motion on the cloth
        ball[POSITION] += shift * nx
        ball[POSITION + 1] += shift * ny
        approach = -(ball[VELOCITY] * nx + ball[VELOCITY + 1] * ny)
        if furniture.model == HAN or approach <= LEAST_APPROACH:
            height = (furniture.height - surface.radius) / surface.radius
            flat = bed.reach / surface.radius
            e = restitution_at(furniture.cushion_restitution, approach * flat)
            strike_fixed(
                surface, ball, flat * nx, flat * ny, -height, e, furniture.cushion_friction
            )
        else:
            strike_lying(surface, furniture, ball, nx, ny)
        ball[CLIMB] = 0.0  # the cloth holds it
        return
    z = ball[HEIGHT] - furniture.height
    distance = np.sqrt(away * away + z * z)
    x, y, z = nx * away / distance, ny * away / distance, z / distance
    approach = -(ball[VELOCITY] * x + ball[VELOCITY + 1] * y + ball[CLIMB] * z)
    e = restitution_at(furniture.cushion_restitution, approach)
    strike_fixed(surface, ball, x, y, z, e, furniture.cushion_friction)


@compiled
def strike_lying(
    surface: Surface, furniture: Furniture, ball: NDArray[np.float64], nx: float, ny: float
) -> None:
    """Let a lying ball strike a cushion with the normal (nx, ny), by Mathavan's model."""
    r = surface.radius
    u, v = ball[VELOCITY], ball[VELOCITY + 1]
    p, q = ball[ANGULAR], ball[ANGULAR + 1]
    # x along the cushion is (-ny, nx), y into it (-nx, -ny)
    vx, vy, wx, wy, wz = bounce_of(
        nx * v - ny * u, -nx * u - ny * v, r * (nx * q - ny * p), -r * (nx * p + ny * q),
        r * ball[ANGULAR + 2], (furniture.height - r) / r, furniture.cushion_restitution,
        furniture.cushion_friction, surface.sliding, surface.mass * r * r / surface.inertia,
    )
    ball[VELOCITY] = -ny * vx - nx * vy
    ball[VELOCITY + 1] = nx * vx - ny * vy
    ball[ANGULAR] = (-ny * wx - nx * wy) / r
    ball[ANGULAR + 1] = (nx * wx - ny * wy) / r
    ball[ANGULAR + 2] = wz / r
