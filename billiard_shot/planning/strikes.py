"""What strikes give the ball, for many strokes at once: what is left when speed and azimuth go."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot.model import StrikeModel
from billiard_shot.shot.strike import strike_batch
from billiard_shot.status import Status

# Of the trajectory on an endless cloth, with a cue of 1 m/s: strikes are then solved to 1e-12.
TOLERANCE = 1e-11  # m

Rows = NDArray[np.float64]


def vectors_of(strokes: Rows) -> tuple[Rows, Rows]:
    """Find unit normals and cue velocities (n, 3) of arguments of from_offsets (n, 5)."""
    a, b, elevation, azimuth, speed = strokes.T
    sin_e, cos_e = np.sin(elevation), np.cos(elevation)
    sin_t, cos_t = np.sin(azimuth), np.cos(azimuth)
    with np.errstate(invalid='ignore'):
        depth = np.sqrt(1.0 - a * a - b * b)  # NaN: the tip misses
    along = np.stack([cos_e * cos_t, cos_e * sin_t, -sin_e], axis=1)
    right = np.stack([sin_t, -cos_t, np.zeros_like(a)], axis=1)
    up = np.stack([sin_e * cos_t, sin_e * sin_t, cos_e], axis=1)
    normals = a[:, None] * right + b[:, None] * up - depth[:, None] * along
    velocities = np.where(speed > 0.0, speed, np.nan)[:, None] * along
    return normals, velocities


def strikes_of(scene: Scene, model: StrikeModel, offsets: Rows) -> Rows:
    """
    Solve strikes of a cue that comes at 1 m/s along azimuth 0.

    Parameters
    ----------
    scene, model : Scene, StrikeModel
    offsets : (n, 3) float array
        a and b in ball radii, and the elevation [rad].

    Returns
    -------
    (n, 6) float array
        Velocity, and spin times radius [m/s]; NaN for what cannot be played.

    """
    strokes = np.zeros((len(offsets), 5))
    strokes[:, :3] = offsets
    strokes[:, 4] = 1.0
    normals, velocities = vectors_of(strokes)
    centre = np.array([0.0, 0.0, scene.ball.radius])
    strikes = strike_batch(model, normals, velocities, centre, TOLERANCE).strikes
    given = np.concatenate([strikes['velocity'], spin_in_metres(scene, strikes['spin'])], axis=1)
    given[strikes['status'] >= Status.MISS] = np.nan
    return given


def spin_in_metres(scene: Scene, spin: Rows) -> Rows:
    """Spin as the speed of the ball's surface [m/s]."""
    surface: Rows = scene.ball.radius * spin
    return surface
