"""Which strokes would be refused, without playing them; and how high the cue must be."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.records import Storage
from billiard_shot.scene import Noise, Scene, SceneLike
from billiard_shot.scene.errors import refused
from billiard_shot.scene.player import B, ELEVATION
from billiard_shot.scene.values import as_float, as_floats
from billiard_shot.shot.accuracy import USUAL_ACCURACY
from billiard_shot.shot.on_table import task_of
from billiard_shot.shot.raising import Raising, write_clear_elevations
from billiard_shot.shot.setting import setting_of
from billiard_shot.shot.stroke import playable_offsets, read_rows, vectors_of
from billiard_shot.status import Status
from billiard_shot.table.clearance import surroundings_of
from billiard_shot.table.event_loop import PLACED
from billiard_shot.table.task import run_tables

STEEPEST = math.radians(89.75)  # elevation that is tried: a vertical cue has no azimuth
MARGIN_SIGMAS = 3.0  # standard deviations of a player's errors for which the cue has clearance


class Margins(NamedTuple):
    """By how much a stroke may be too low and the cue must still have clearance."""

    b: float  # ball radii: in place of b
    elevation: float  # rad


def margins_for(noise: Noise, radius: float) -> Margins:
    """Return the margins for the errors of a player of balls of a radius [m]."""
    _, b, elevation, _, _ = (MARGIN_SIGMAS * noise.sigmas(radius)).tolist()
    return Margins(b, elevation)


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
    task = task_of(setting_of(scene), normals, velocities, None, USUAL_ACCURACY)
    if position is not None:
        starts = task.starts.copy()
        starts['position'][:, 0] = position
        task = task._replace(starts=starts)
    status: NDArray[np.int64] = run_tables(task._replace(until=PLACED)).cues['status']
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
        Elevations [rad], at most 0.05 degrees above the lowest; infinite where no elevation below
        the vertical gives the cue clearance, or no stroke can have these offsets.

    Raises
    ------
    ValueError
        If an array has another shape, or the margin is out of range.

    """
    scene = Scene.load(scene)
    if not 0.0 <= as_float(margin) <= 0.5 * math.pi:
        raise refused(margin, f'0 to {0.5 * math.pi:.4g}', 'margin', 'rad')
    strokes = read_rows('offsets', offsets, 5).copy()
    place = None if position is None else as_floats(position)
    if place is not None and place.shape != (3,):
        raise ValueError(f'position must be of shape (3,), got {place.shape}')
    strokes[:, ELEVATION] = 0.0
    strokes = playable_offsets(strokes)
    first, margins = np.full(len(strokes), margin), Margins(0.0, margin)
    strokes[:, ELEVATION] = first_clear(scene, strokes, first, STEEPEST, margins, place)
    playable = refusals_in(scene, *vectors_of(strokes), place) == Status.OK
    return np.where(playable, strokes[:, ELEVATION], np.inf)


def first_clear(
    scene: Scene,
    strokes: NDArray[np.float64],
    first: NDArray[np.float64],
    highest: float,
    margins: Margins,
    position: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """
    Find elevations (n,) at which the cues of strokes (n, 5) have clearance, with margins [rad].

    They are the lowest ones from `first` (n,) to `highest`, or NaN; see `clear_elevation`.
    """
    run = write_clear_elevations.current()
    storage = run.storage
    lowered = strokes.copy()
    lowered[:, B] -= margins.b
    found = storage.array(first.copy())
    raising = raising_of(storage, scene, highest, margins.elevation, position)
    run(raising, storage.array(lowered), found)
    return np.asarray(found)


def raising_of(
    storage: Storage,
    scene: Scene,
    highest: float,
    margin: float,
    position: NDArray[np.float64] | None = None,
) -> Raising:
    """State how cues in a scene are raised; see `Raising`."""
    return Raising(
        surroundings_of(scene).stored(storage),
        storage.array(np.array(scene.cue_ball) if position is None else position),
        highest,
        margin,
        storage.zeros(2, 3),
    )
