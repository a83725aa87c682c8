"""Many strokes at the same ball, of which only the strike of each is wanted."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot.clearance import apply_refusals, clearance_status, mask_refused
from billiard_shot.shot.model import StrikeModel
from billiard_shot.shot.strike import strike_batch, Strikes


def strike_batch_with_clearance(
    scene: Scene,
    model: StrikeModel,
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
    position: NDArray[np.float64],
    tolerance: float,
    phases: int = 0,
    segments: int = 0,
) -> tuple[Strikes, NDArray[np.float64]]:
    """
    Play strokes as `strike_batch` does, if the cue has room among what the scene has.

    Returns the strikes, and the velocities of the strokes as they were played.
    """
    refused = clearance_status(scene, position, normals, velocities)
    if refused.any():  # OK is 0
        velocities = mask_refused(velocities, refused)
    played = strike_batch(model, normals, velocities, position, tolerance, phases, segments)
    apply_refusals(played.strikes, refused)
    return played, velocities
