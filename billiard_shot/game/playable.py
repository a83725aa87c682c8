"""Strokes that can be played with clearance of the cue, in spite of the player's errors."""

from collections.abc import Sequence
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import limits_of, raise_for_clearance
from billiard_shot.planning.strikes import along_azimuth
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import refused
from billiard_shot.scene.player import AZIMUTH, ELEVATION, SPEED
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.stroke import Stroke

ROUNDING = 1e-9  # degrees


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


def playable_stroke(
    scene: Scene, degrees: Sequence[float], *, stated: bool, aimed: bool
) -> Stroke:
    """
    Make a stroke that its player can play in spite of its errors.

    Parameters
    ----------
    scene : Scene
        With its `robot`, `noise` and balls.
    degrees : sequence of 5 floats
        a, b, elevation, azimuth, speed as of `Stroke.from_offsets`; angles in degrees.
    stated : bool
        Whether the elevation is given; otherwise it is the lowest one with room for errors.
    aimed : bool
        Whether the azimuth is that of the cue ball, not of the cue: with side spin they differ.

    Raises
    ------
    ValueError
        If a number is beyond the limits of the scene, or the cue has no room for errors.

    """
    a, b, elevation, azimuth, speed = degrees
    wanted = Stroke.from_offsets(
        a, b, elevation_deg=elevation, azimuth_deg=azimuth, speed=speed
    ).offsets
    robot, highest = scene.robot, scene.robot.elevation_max_deg
    for name, value, low, high, unit in (
        ('distance from the middle', math.hypot(a, b), 0.0, robot.offset_max, 'ball radii'),
        ('ELEVATION', elevation, 0.0, highest, 'degrees'),
        ('SPEED', speed, robot.speed_min, robot.speed_max, 'm/s'),
    ):
        if not low <= value <= high:
            raise refused(value, f'{low:g} to {high:g}', name, unit)
    limits, row = limits_of(scene, None, scene.noise), np.array([wanted])
    row = raise_for_clearance(scene, limits, row)
    lowest = math.degrees(row[0, ELEVATION])
    if math.isnan(lowest):
        raise ValueError(f'the cue has no room there at any elevation up to {highest:g} degrees')
    if stated and lowest > elevation + ROUNDING:
        allowed = f'at least {math.ceil(10.0 * lowest) / 10.0:g}, to leave room for errors'
        raise refused(elevation, allowed, 'ELEVATION', 'degrees')
    if aimed:
        row = along_azimuth(model_of(scene), row)
    return Stroke.from_offsets(*row[0].tolist())
