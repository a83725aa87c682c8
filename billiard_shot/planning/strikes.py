"""Velocity and spin after many strikes at once, for a cue speed of 1 m/s and azimuth 0."""

import numpy as np

from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.player import SPEED
from billiard_shot.shot.model import StrikeModel
from billiard_shot.shot.on_table import strike
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.status import Status

# Trajectory tolerance on an endless cloth at a cue speed of 1 m/s: strikes are solved to 1e-12.
STRIKE_TOLERANCE = 1e-11  # m


def unit_speed_strikes(scene: Scene, model: StrikeModel, offsets: Array) -> Array:
    """
    Solve strikes with a cue speed of 1 m/s and azimuth 0.

    Parameters
    ----------
    scene, model : Scene, StrikeModel
    offsets : (n, 3) float array
        a and b in ball radii, and the elevation [rad].

    Returns
    -------
    (n, 6) float array
        Velocity, and spin times radius [m/s]; NaN for strokes that cannot be played.

    """
    strokes = np.zeros((len(offsets), 5))
    strokes[:, :3] = offsets
    strokes[:, SPEED] = 1.0
    return motions_after(scene, model, strokes)


def along_azimuth(scene: Scene, model: StrikeModel, strokes: Array) -> Array:
    """Turn strokes (n, 5) so that the ball, not the cue, starts along their azimuth."""
    # the direction in which the ball starts, relative to the azimuth, depends on neither speed
    # nor azimuth
    offsets, which = np.unique(strokes[:, :3].round(6), axis=0, return_inverse=True)
    motion = unit_speed_strikes(scene, model, offsets)[which.ravel()]
    turned = strokes.copy()
    turned[:, 3] -= np.nan_to_num(np.arctan2(motion[:, 1], motion[:, 0]))
    return turned


def motions_after(scene: Scene, model: StrikeModel, strokes: Array) -> Array:
    """
    Solve strikes; return velocity, and spin times radius (n, 6) [m/s].

    Strokes (n, 5) are as in `vectors_of`. The result is NaN for strokes that cannot be played.
    """
    strikes = strike(model, *vectors_of(strokes), STRIKE_TOLERANCE)
    result = np.concatenate([strikes['velocity'], surface_speed(scene, strikes['spin'])], axis=1)
    result[strikes['status'] >= Status.MISS] = np.nan
    return result


def surface_speed(scene: Scene, spin: Array) -> Array:
    """Spin times radius [m/s]: the speed of the ball's surface."""
    surface: Array = scene.ball.radius * spin
    return surface
