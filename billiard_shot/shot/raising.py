"""How high the cue must be for each of many strokes."""

from math import nan, radians
from typing import Any, NamedTuple

from billiard_shot.compiled import entry, inner
from billiard_shot.records import Floats, Storage
from billiard_shot.shot.stroke_vectors import write_vectors
from billiard_shot.status import CUE_THROUGH_BALL, CUE_THROUGH_CLOTH, CUE_THROUGH_CUSHION
from billiard_shot.table.clearance import least_turn, nothing_around, Surroundings
from billiard_shot.table.cue_placement import refusal

ELEVATION_STEP = radians(0.05)  # by which the result may exceed the lowest elevation


class Raising(NamedTuple):
    """What cues have to clear, and the elevations that are tried."""

    around: Surroundings
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
        status = refusal(raising.around, normal, axis, raising.place)
        if status in (CUE_THROUGH_BALL, CUE_THROUGH_CUSHION):
            elevation += least_turn(raising.around, normal, axis, raising.place)
        elif status != CUE_THROUGH_CLOTH:
            return elevation
        elevation += ELEVATION_STEP
    return nan


def example_raising(storage: Storage) -> Raising:
    """Make an example of how cues are raised."""
    around = nothing_around(0.0, 1.0).stored(storage)
    return Raising(around, storage.zeros(3), 1.0, 0.0, storage.zeros(2, 3))


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
