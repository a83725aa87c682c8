"""Which strokes would be refused, without playing them."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot.clearance import surroundings_of
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.strike_batch import refusals
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status


def refusals_in(
    scene: Scene,
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
    position: NDArray[np.float64] | None = None,
) -> NDArray[np.int64]:
    """
    Find the status (n,) with which each stroke at the cue ball would be refused, or OK.

    Parameters
    ----------
    scene : Scene
    normals, velocities : (n, 3) float arrays
        As of `Stroke`.
    position : (3,) float array, optional
        Centre of the cue ball [m]; by default where the scene has it.

    """
    centre = np.array(scene.cue_ball) if position is None else position
    return refusals(model_of(scene), surroundings_of(scene), normals, velocities, centre)


def least_elevation(
    scene: Scene,
    a: float,
    b: float,
    azimuth: float,
    position: NDArray[np.float64] | None = None,
) -> float:
    """
    Elevation [rad], in steps of a quarter of a degree, from which on the cue has room.

    Of a stroke at (a, b), see `Stroke.from_offsets`, on the cue ball of a scene, or on one at
    `position` (3,) [m]; infinite where there is none.
    """
    steps = np.radians(np.arange(0.0, 90.0, 0.25))
    strokes = [Stroke.from_offsets(a, b, float(step), azimuth, 1.0) for step in steps]
    status = refusals_in(
        scene,
        np.array([stroke.normal for stroke in strokes]),
        np.array([stroke.velocity for stroke in strokes]),
        position,
    )
    free = steps[status == Status.OK]
    return float(free[0]) if len(free) else np.inf
