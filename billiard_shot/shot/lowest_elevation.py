"""How high the cue must be: which strokes would be refused, without playing them."""

import math
from math import nan, radians
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.records import Floats, Storage
from billiard_shot.scene import Noise, Scene, SceneLike
from billiard_shot.scene.errors import refused
from billiard_shot.scene.fields import as_float, as_floats
from billiard_shot.scene.player import B, ELEVATION
from billiard_shot.shot.play import prepared_scene, task_of, USUAL_ACCURACY
from billiard_shot.shot.stroke import playable_offsets, read_rows, vectors_of, write_vectors
from billiard_shot.status import CUE_THROUGH_BALL, CUE_THROUGH_CLOTH, CUE_THROUGH_CUSHION, OK
from billiard_shot.table.run.event_loop import PLACED
from billiard_shot.table.run.task import run_tables
from billiard_shot.table.strike import placement

ELEVATION_STEP = radians(0.05)  # by which the result may exceed the lowest elevation


class Raising(NamedTuple):
    """What cues have to clear, and the elevations that are tried."""

    obstacles: placement.Surroundings
    place: Floats  # (3,) m, centre of the cue ball
    highest: float  # rad
    margin: float  # rad: the cue must have clearance at an elevation that is lower by this as well
    scratch: Floats  # (2, 3)


@inner
def clear_elevation(raising: Raising, stroke: Floats, first: float) -> float:
    """
    Find the lowest elevation, not below the first, at which the cue has clearance [rad], or NaN.

    It is found to `ELEVATION_STEP`. Strokes that are refused for another reason have clearance.
    The elevation of `stroke` does not count.
    """
    normal, axis = raising.scratch[0], raising.scratch[1]
    elevation = first
    while elevation <= raising.highest:
        write_vectors(stroke, max(elevation - raising.margin, 0.0), normal, axis)
        status = placement.refusal(raising.obstacles, normal, axis, raising.place)
        if status in (CUE_THROUGH_BALL, CUE_THROUGH_CUSHION):
            elevation += placement.least_turn(raising.obstacles, normal, axis, raising.place)
        elif status != CUE_THROUGH_CLOTH:
            return elevation
        elevation += ELEVATION_STEP
    return nan


def example_raising(storage: Storage) -> Raising:
    """Make an example of how cues are raised."""
    obstacles = placement.nothing_around(0.0, 1.0).stored(storage)
    return Raising(obstacles, storage.zeros(3), 1.0, 0.0, storage.zeros(2, 3))


def _example(storage: Storage) -> tuple[Any, ...]:
    return example_raising(storage), storage.zeros(1, 5), storage.zeros(1)


@entry(_example)
def write_clear_elevations(raising: Raising, strokes: Floats, elevations: Floats) -> None:
    """
    Raise cues until they have clearance.

    Parameters
    ----------
    raising : Raising
    strokes : (n, 5) floats
        See `vectors_of`.
    elevations : (n,) floats, written
        The first that is tried for each stroke; then the result of `clear_elevation` [rad].

    """
    for i in range(len(elevations)):
        elevations[i] = clear_elevation(raising, strokes[i], elevations[i])


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
    task = task_of(prepared_scene(scene), normals, velocities, None, USUAL_ACCURACY)
    if position is not None:
        starts = task.starts.copy()
        starts['position'][:, 0] = position
        task = task._replace(starts=starts)
    status: NDArray[np.int64] = run_tables(task._replace(until=PLACED)).cues['status']
    return status


def lowest_elevation(
    scene: SceneLike, offsets: ArrayLike, position: ArrayLike | None = None, margin: float = 0.0
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
    playable = refusals_in(scene, *vectors_of(strokes), place) == OK
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
        placement.surroundings_of(scene).stored(storage),
        storage.array(np.array(scene.cue_ball) if position is None else position),
        highest,
        margin,
        storage.zeros(2, 3),
    )
