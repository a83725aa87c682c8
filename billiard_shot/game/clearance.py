"""Strokes that the robot can play with clearance of the cue, in spite of its errors."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import limits_of, raise_for_clearance
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.player import AZIMUTH, SPEED


def raised(scene: Scene, offsets: Array) -> tuple[Array, NDArray[np.bool_]]:
    """
    Raise the cue as little as it needs for clearance, and keep the speed within its limits.

    Parameters
    ----------
    scene : Scene
        With its `robot`, `noise` and balls.
    offsets : (n, 5) float array

    Returns
    -------
    offsets : (n, 5) float array
        NaN for strokes without clearance.
    playable : (n,) bool array
        Whether a stroke is within the limits of the robot.

    """
    limits, robot = limits_of(scene, None, scene.noise), scene.robot
    found = offsets.copy()
    found[:, SPEED] = np.clip(found[:, SPEED], robot.speed_min, robot.speed_max)
    found = raise_for_clearance(scene, limits, found)
    return found, limits.allows_azimuth(offsets[:, AZIMUTH]) & np.isfinite(found).all(axis=1)
