"""Many strokes at the same ball, of which only the row of numbers of each is wanted."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot import row as at
from billiard_shot.shot.clearance import held_back, overrule, refuse
from billiard_shot.shot.model import Model
from billiard_shot.shot.strike import shoot
from billiard_shot.table import motion


def shoot_rows(
    model: Model, normals: NDArray[np.float64], velocities: NDArray[np.float64],
    position: NDArray[np.float64], tolerance: float,
) -> NDArray[np.float64]:
    """Rows (n, COLUMNS) of strokes on an endless cloth, without phases and trajectories."""
    rows = np.empty((len(normals), at.COLUMNS))
    shoot(
        model, normals, velocities, position, tolerance, rows, np.empty((0, 12)),
        np.empty((0, motion.COLUMNS)),
    )
    return rows


def shoot_with_room(
    scene: Scene, model: Model, normals: NDArray[np.float64], velocities: NDArray[np.float64],
    position: NDArray[np.float64], tolerance: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Play strokes as `shoot_rows` does, but only where the cue has room among what the scene has.

    Returns the rows, and the velocities of the strokes as they were played.
    """
    refused = refuse(scene, position, normals, velocities)
    velocities = held_back(velocities, refused)
    rows = shoot_rows(model, normals, velocities, position, tolerance)
    overrule(rows, refused)
    return rows, velocities
