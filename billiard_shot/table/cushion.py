"""What a cushion does to a ball: by the model that the scene asks for, or an edge to a flier."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.airborne import edge_at
from billiard_shot.table.furniture import Bed, Furniture, MATHAVAN
from billiard_shot.table.mathavan import bounce_of
from billiard_shot.table.motion import ANGULAR, CLIMB, HEIGHT, POSITION, VELOCITY
from billiard_shot.table.sphere import strike_fixed
from billiard_shot.table.surface import Surface


@fused
def touch_edge(
    furniture: Furniture, bed: Bed, radius: float, ball: NDArray[np.float64], what: int
) -> tuple[float, float, float, bool]:
    """Find the normal where a ball touches a nose, facing or arc, and whether the ball lies."""
    x, y, away = edge_at(bed, what, ball[POSITION], ball[POSITION + 1])
    if ball[HEIGHT] == radius:
        shift = bed.reach - away  # rounding; or pressed in by its motion on the cloth
        ball[POSITION] += shift * x
        ball[POSITION + 1] += shift * y
        flat = bed.reach / radius
        return flat * x, flat * y, 1.0 - furniture.height / radius, True
    z = ball[HEIGHT] - furniture.height
    distance = np.sqrt(away * away + z * z)
    return x * away / distance, y * away / distance, z / distance, False


@fused
def strike_cushion(
    surface: Surface, furniture: Furniture, ball: NDArray[np.float64], lying: bool,
    x: float, y: float, z: float, restitution: float,
) -> None:
    """Let a ball strike a cushion whose normal, where they touch, is (x, y, z)."""
    if lying and furniture.model == MATHAVAN and restitution > 0.0:
        flat = np.sqrt(x * x + y * y)
        strike_lying(surface, furniture, ball, x / flat, y / flat, restitution)
    else:
        strike_fixed(surface, ball, x, y, z, restitution, furniture.cushion_friction)
    if lying:
        ball[CLIMB] = 0.0  # the cloth holds it


@fused
def strike_lying(
    surface: Surface, furniture: Furniture, ball: NDArray[np.float64], nx: float, ny: float,
    restitution: float,
) -> None:
    """Let a lying ball strike a cushion with the normal (nx, ny), by Mathavan's model."""
    r = surface.radius
    u, v = ball[VELOCITY], ball[VELOCITY + 1]
    p, q = ball[ANGULAR], ball[ANGULAR + 1]
    # x along the cushion is (-ny, nx), y into it (-nx, -ny)
    vx, vy, wx, wy, wz = bounce_of(
        nx * v - ny * u, -nx * u - ny * v, r * (nx * q - ny * p), -r * (nx * p + ny * q),
        r * ball[ANGULAR + 2], (furniture.height - r) / r, restitution,
        furniture.cushion_friction, min(surface.sliding, 1e3),
        surface.mass * r * r / surface.inertia,
    )
    ball[VELOCITY] = -ny * vx - nx * vy
    ball[VELOCITY + 1] = nx * vx - ny * vy
    ball[ANGULAR] = (-ny * wx - nx * wy) / r
    ball[ANGULAR + 1] = (nx * wx - ny * wy) / r
    ball[ANGULAR + 2] = wz / r
