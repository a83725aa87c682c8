"""Clearance of the cue in planned strokes, in spite of the errors of the player."""

import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot.refusals import lowest_elevation

Array = NDArray[np.float64]

SIGMAS = 2.5  # of the errors of the height of the cue above a ball just behind the cue ball


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
    playable : (n,) bool array
        Whether a stroke is within the limits of the robot.

    """
    robot, noise = scene.robot, scene.noise
    found = offsets.copy()
    found[:, 4] = np.clip(found[:, 4], robot.speed_min, robot.speed_max)
    height = noise.b / (2.0 * scene.ball.radius)
    margin = SIGMAS * math.hypot(math.radians(noise.elevation_deg), height)
    lowest = np.maximum(lowest_elevation(scene, found), math.radians(robot.elevation_min_deg))
    found[:, 2] = lowest + margin
    turned = np.remainder(found[:, 3] - math.radians(robot.azimuth_deg) + math.pi, math.tau)
    within = np.abs(turned - math.pi) <= math.radians(robot.azimuth_half_range_deg) + 1e-9
    return found, within & (found[:, 2] <= math.radians(robot.elevation_max_deg))
