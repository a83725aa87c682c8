"""The ball after strikes on an endless cloth with nothing near: many strokes at once."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array
from billiard_shot.scene.player import AZIMUTH
from billiard_shot.shot.on_table import strike
from billiard_shot.shot.strike_model import StrikeModel
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.status import Status

STRIKE_TOLERANCE = 1e-4  # m, of the trajectories


class Struck(NamedTuple):
    """
    Ball and cue after n strikes.

    Attributes
    ----------
    velocity, surface : (n, 3) float arrays
        Velocity of the ball, and its spin times its radius [m/s]; NaN if the stroke cannot be
        played.
    cue_speed : (n,) float array
        [m/s]
    regular : (n,) bool array
        Whether the strike was solved, with one hit and without a miscue.
    fails : (n,) bool array
        Whether the stroke cannot be played, or is a miscue or a double hit.

    """

    velocity: Array
    surface: Array
    cue_speed: Array
    regular: NDArray[np.bool_]
    fails: NDArray[np.bool_]


def strike_alone(
    model: StrikeModel, strokes: Array, tolerance: float = STRIKE_TOLERANCE
) -> Struck:
    """Strike the ball with strokes (n, 5), see `vectors_of`."""
    cues = strike(model, *vectors_of(strokes), tolerance)
    refused = cues['status'] >= Status.MISS
    played = np.where(refused, np.nan, 1.0)
    regular = (cues['status'] == Status.OK) & ~cues['miscue'] & (cues['hits'] == 1)
    velocity, spin = (played[:, np.newaxis] * cues[name] for name in ('velocity', 'spin'))
    fails = refused | cues['miscue'] | (cues['double_hit'] == 0.0)
    return Struck(velocity, model.surface.radius * spin, played * cues['speed'], regular, fails)


def along_azimuth(model: StrikeModel, strokes: Array) -> Array:
    """Turn strokes (n, 5) so that the ball, not the cue, starts along their azimuth."""
    along_x = strokes.copy()
    along_x[:, AZIMUTH] = 0.0
    different, which = np.unique(along_x.round(6), axis=0, return_inverse=True)
    x, y, _ = strike_alone(model, different).velocity[which.ravel()].T
    turned = strokes.copy()
    turned[:, AZIMUTH] -= np.nan_to_num(np.arctan2(y, x))
    return turned
