"""Which strokes would be refused, without playing them; and how high the cue must be."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.errors import refused
from billiard_shot.scene.player import ELEVATION
from billiard_shot.scene.values import as_float, as_floats
from billiard_shot.shot.clear_elevation import Trials, write_clear_elevations
from billiard_shot.shot.clearance import surroundings_of
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.setting import setting_of
from billiard_shot.shot.strike import cues_of
from billiard_shot.shot.stroke import playable_offsets, vectors_of
from billiard_shot.status import Status

# Steps of the elevations that are tried [rad].
COARSE_ELEVATION_STEP, FINE_ELEVATION_STEP = math.radians(4.0), math.radians(0.25)


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
    setting = setting_of(scene)
    starts = setting.starts.copy()
    if position is not None:
        starts['position'][:, 0] = position
    status: NDArray[np.int64] = cues_of(setting, normals, velocities, starts)['status']
    return status


def lowest_elevation(
    scene: SceneLike,
    offsets: ArrayLike,
    position: ArrayLike | None = None,
    margin: float = 0.0,
) -> NDArray[np.float64]:
    """
    Find the lowest elevation of each of many strokes at which the cue has clearance.

    Parameters
    ----------
    scene : Scene, str or Path
    offsets : (n, 5) array_like
        As of `predict_batch`; the elevation in them does not count.
    position : (3,) array_like, optional
        Centre of the cue ball [m]; by default where the scene has it.
    margin : float
        Angle by which the cue can be lower than that and still has clearance, and does not point
        up [rad], 0 to pi/2.

    Returns
    -------
    (n,) float array
        Elevations [rad], in steps of a quarter of a degree; infinite where no elevation below the
        vertical gives the cue clearance, or no stroke can have these offsets.

    Raises
    ------
    ValueError
        If an array has another shape, or the margin is out of range.

    """
    scene = Scene.load(scene)
    if not 0.0 <= as_float(margin) <= 0.5 * math.pi:
        raise refused(margin, f'0 to {0.5 * math.pi:.4g}', 'margin', 'rad')
    strokes = as_floats(offsets).copy()
    if strokes.ndim != 2 or strokes.shape[1] != 5:
        raise ValueError(f'offsets must be of shape (n, 5), got {strokes.shape}')
    place = None if position is None else as_floats(position)
    if place is not None and place.shape != (3,):
        raise ValueError(f'position must be of shape (3,), got {place.shape}')
    strokes[:, ELEVATION] = 0.0
    strokes = playable_offsets(strokes)
    highest = 0.5 * math.pi - FINE_ELEVATION_STEP
    level = FINE_ELEVATION_STEP * math.ceil(margin / FINE_ELEVATION_STEP)
    begin = np.full(len(strokes), level)
    strokes[:, ELEVATION] = first_free(scene, strokes, begin, highest, margin, place)
    playable = refusals_in(scene, *vectors_of(strokes), place) == Status.OK
    return np.where(playable, strokes[:, ELEVATION], np.inf)


def first_free(
    scene: Scene,
    strokes: NDArray[np.float64],
    begin: NDArray[np.float64],
    highest: float,
    margin: float,
    position: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """
    Find the lowest elevations at which the cue has clearance, also if it is lower by a margin.

    Coarse steps come first; fine steps then look for clearance within the last coarse one.

    Parameters
    ----------
    scene : Scene
    strokes : (n, 5) float array
        See `vectors_of`; their elevations do not count.
    begin : (n,) float array
        The first elevations that are tried [rad].
    highest, margin : float
        The largest of the elevations that are tried, and the margin [rad].
    position : (3,) float array, optional
        As of `refusals_in`.

    Returns
    -------
    (n,) float array
        [rad]; NaN where no elevation gives clearance. Strokes that are refused for another reason
        have clearance.

    """
    run = write_clear_elevations.current()
    storage, array = run.storage, run.storage.array
    model, around = model_of(scene), surroundings_of(scene).stored(storage)
    place = array(np.array(scene.cue_ball) if position is None else position)
    rows, scratch, found = array(strokes), storage.zeros(2, 3), begin
    for step in (COARSE_ELEVATION_STEP, FINE_ELEVATION_STEP):
        tried = array(found.copy())
        run(model, around, place, rows, Trials(step, highest, margin), scratch, tried)
        found = np.asarray(tried)
        if step == COARSE_ELEVATION_STEP:
            found = np.maximum(found - COARSE_ELEVATION_STEP + FINE_ELEVATION_STEP, begin)
    return found
