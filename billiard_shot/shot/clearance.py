"""
Whether the cue has room: a stroke that would go through a ball or a cushion is refused.

The cue is a cone from its tip, `tip_radius` thin, to its end, `BUTT` thick. A cushion is in its
way where it passes below the line of noses; the frame behind is no higher.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.run import NOSE_NAMES

BUTT = 0.0145  # m: half of the 29 mm that most cues measure at their end
ROUNDING = 1e-9  # m
CUE = 'cue'


class Obstacle(NamedTuple):
    """What is in the way, and how deep the cue would go into it [m], for each stroke."""

    name: str
    status: Status
    depth: NDArray[np.float64]  # (n,) negative where there is room


@np.errstate(invalid='ignore', divide='ignore')
def obstacles(
    scene: Scene,
    centre: NDArray[np.float64],
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
) -> list[Obstacle]:
    """
    All balls and cushions that may be in the way of strokes.

    Parameters
    ----------
    scene : Scene
    centre : (3,) float array
        Of the cue ball [m].
    normals, velocities : (n, 3) float arrays
        Unit vectors, and [m/s].

    """
    if scene.cue.length == 0.0:
        return []
    back = -velocities / np.linalg.norm(velocities, axis=1, keepdims=True)
    tip = centre + scene.ball.radius * normals
    found = [_ball(scene, name, tip, back) for name in scene.balls if name != CUE]
    return found + ([_cushion(scene, nose, tip, back) for nose in range(4)] if scene.table else [])


@np.errstate(invalid='ignore', divide='ignore', over='ignore')
def clearance_status(
    scene: Scene,
    centre: NDArray[np.float64],
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
) -> NDArray[np.float64]:
    """
    Status (n,) of strokes: OK, CUE_THROUGH_BALL or CUE_THROUGH_CUSHION.

    Invalid strokes, and strokes that are refused for other reasons, are OK here.
    """
    status = np.full(len(normals), float(Status.OK))
    if scene.cue.length == 0.0 or (scene.table is None and not set(scene.balls) - {CUE}):
        return status
    level = np.hypot(velocities[:, 0], velocities[:, 1]) / np.linalg.norm(velocities, axis=1)
    lowest = scene.ball.radius * (1.0 + normals[:, 2]) - scene.cue.tip_radius * level
    open_to = ((normals * velocities).sum(axis=1) < 0.0) & (velocities[:, 2] <= 0.0)
    open_to &= lowest > -ROUNDING
    for obstacle in obstacles(scene, centre, normals, velocities):
        status[open_to & (status == Status.OK) & (obstacle.depth > ROUNDING)] = obstacle.status
    return status


def least_elevation(scene: Scene, a: float, b: float, azimuth: float) -> float:
    """
    Elevation [rad], in steps of a quarter of a degree, from which on the cue has room.

    Of a stroke at (a, b), see `Stroke.from_offsets`, on the cue ball of a scene; infinite where
    there is none.
    """
    steps = np.radians(np.arange(0.0, 90.0, 0.25))
    strokes = [Stroke.from_offsets(a, b, float(step), azimuth, 1.0) for step in steps]
    status = clearance_status(
        scene,
        np.array(scene.cue_ball),
        np.array([stroke.normal for stroke in strokes]),
        np.array([stroke.velocity for stroke in strokes]),
    )
    free = steps[status == Status.OK]
    return float(free[0]) if len(free) else np.inf


def apply_refusals(strikes: NDArray[np.void], status: NDArray[np.float64]) -> None:
    """Write refusals into the strikes of strokes that were masked for them."""
    refused = status != Status.OK
    strikes['status'][refused] = status[refused]


def mask_refused(
    velocities: NDArray[np.float64], status: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Velocities with those of refused strokes set to NaN, so that they are not played."""
    return np.where(status[:, np.newaxis] == Status.OK, velocities, np.nan)


def _thickness(scene: Scene, along: NDArray[np.float64]) -> NDArray[np.float64]:
    thin: float = scene.cue.tip_radius
    thicker: NDArray[np.float64] = thin + (BUTT - thin) * along / scene.cue.length
    return thicker


def _ball(
    scene: Scene, name: str, tip: NDArray[np.float64], back: NDArray[np.float64]
) -> Obstacle:
    there = np.array([*scene.balls[name], scene.ball.radius]) - tip
    along = np.clip((there * back).sum(axis=1), 0.0, scene.cue.length)
    distance = np.linalg.norm(there - along[:, np.newaxis] * back, axis=1)
    # what reaches no farther back than the tip is in front of the cue
    behind = along > 0.0
    depth = np.where(behind, scene.ball.radius + _thickness(scene, along) - distance, -np.inf)
    return Obstacle(f'ball {name!r}', Status.CUE_THROUGH_BALL, depth)


def _cushion(
    scene: Scene, nose: int, tip: NDArray[np.float64], back: NDArray[np.float64]
) -> Obstacle:
    table = scene.table
    assert table is not None
    axis, sign = nose // 2, 1.0 - 2.0 * (nose % 2)
    half = 0.5 * (table.length if axis == 0 else table.width)
    along = (half - sign * tip[:, axis]) / (sign * back[:, axis])
    level = np.hypot(back[:, 0], back[:, 1])
    height = tip[:, 2] + along * back[:, 2] - _thickness(scene, along) / level
    over = (along >= 0.0) & (along <= scene.cue.length)
    depth = np.where(over, 2.0 * scene.ball.radius * table.cushion.height - height, -np.inf)
    return Obstacle(f'the {NOSE_NAMES[nose]} cushion', Status.CUE_THROUGH_CUSHION, depth)
