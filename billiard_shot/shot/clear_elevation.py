"""How high the cue must be for each of many strokes: all elevations are tried in compiled code."""

from math import isnan, nan, sqrt
from typing import Any, NamedTuple

from billiard_shot.compiled import entry, inner
from billiard_shot.records import Floats, Storage
from billiard_shot.scene.player import A, AZIMUTH, B
from billiard_shot.shot.clearance import NOTHING_AROUND, Surroundings
from billiard_shot.shot.model import StrikeModel
from billiard_shot.shot.strike import EXAMPLE_MODEL, refusal
from billiard_shot.shot.stroke import axes
from billiard_shot.status import CUE_THROUGH_BALL, CUE_THROUGH_CLOTH, CUE_THROUGH_CUSHION


class Trials(NamedTuple):
    """Elevations that are tried."""

    step: float  # rad
    highest: float  # rad
    margin: float  # rad: the cue must have clearance at an elevation that is lower by this as well


@inner
def write_vectors(stroke: Floats, elevation: float, normal: Floats, axis: Floats) -> None:
    """Write the unit normal and the axis of a stroke at an elevation [rad], see `vectors_of`."""
    a, b = stroke[A], stroke[B]
    right, up, along = axes(elevation, stroke[AZIMUTH])
    depth = sqrt(max(1.0 - a * a - b * b, 0.0))
    length = sqrt(a * a + b * b + depth * depth)
    for k in range(3):
        axis[k] = along[k]
        normal[k] = (a * right[k] + b * up[k] - depth * along[k]) / length


def _example(storage: Storage) -> tuple[Any, ...]:
    zeros = storage.zeros
    around = NOTHING_AROUND.stored(storage)
    trials = Trials(1.0, 1.0, 0.0)
    return EXAMPLE_MODEL, around, zeros(3), zeros(1, 5), trials, zeros(2, 3), zeros(1)


@entry(_example)
def write_clear_elevations(
    model: StrikeModel,
    around: Surroundings,
    place: Floats,
    strokes: Floats,
    trials: Trials,
    scratch: Floats,
    elevations: Floats,
) -> None:
    """
    Raise cues, step by step, until they have clearance.

    Parameters
    ----------
    model, around : StrikeModel, Surroundings
    place : (3,) floats
        Centre of the cue ball [m].
    strokes : (n, 5) floats
        See `vectors_of`; their elevations do not count.
    trials : Trials
    scratch : (2, 3) floats
    elevations : (n,) floats, written
        The first that is tried for each stroke, or NaN; then the first with clearance, or NaN
        [rad]. Strokes that are refused for another reason have clearance.

    """
    normal, axis = scratch[0], scratch[1]
    for i in range(len(elevations)):
        tried, found = elevations[i], nan
        while isnan(found):
            write_vectors(strokes[i], max(tried - trials.margin, 0.0), normal, axis)
            status = refusal(model, around, normal, axis, place)
            if status not in (CUE_THROUGH_CLOTH, CUE_THROUGH_BALL, CUE_THROUGH_CUSHION):
                found = tried
            tried += trials.step
            if not tried <= trials.highest + trials.step:
                break
        elevations[i] = found
