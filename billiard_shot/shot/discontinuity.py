"""
Where a law is discontinuous: strikes with two outcomes, however accurately they are solved.

Law `energetic` ends a contact at a finite force, so that a contact that ends just before it would
have been compressed anew and one that is just compressed anew lead to different motions.
"""

import numpy as np

from billiard_shot.impact.laws import ENERGETIC
from billiard_shot.records import Array
from billiard_shot.shot.accuracy import Accuracy
from billiard_shot.shot.on_table import task_of
from billiard_shot.shot.setting import alone
from billiard_shot.shot.strike_model import StrikeModel
from billiard_shot.status import INFINITE_SEQUENCE, MISS, OK, TOLERANCE_NOT_REACHED
from billiard_shot.table.stroke_accuracy import FINER
from billiard_shot.table.task import BatchRecording, run_tables

# Tolerances of the strike, relative to the stiffness: near enough to be on a jump.
NEAR_A_JUMP = 10.0
COARSEST_STRIKE = 1e-6  # tolerance of a strike
SUSPECT = 1e4  # changes of the stiffness: margins of decisions that they may turn are smaller


def with_discontinuities(
    played: BatchRecording, model: StrikeModel, normals: Array, velocities: Array, tolerance: float
) -> BatchRecording:
    """
    Find how far the resting places of strokes jump, on endless cloth, and note it in their ends.

    A strike that comes close to a decision is solved again with the tip a little stiffer and a
    little softer, by as much as its accuracy is. The changes of a continuous outcome cancel. If
    more than the tolerance is left, the outcome jumps in between.

    Parameters
    ----------
    played : BatchRecording
        Of n strokes. Those in which the ball reached others do not jump. Its errors and status are
        changed.
    model : StrikeModel
    normals, velocities : (n, 3) float arrays
        As of `Stroke`.
    tolerance : float
        Of the trajectories [m].

    """
    if model.law != ENERGETIC:  # the others have next to none
        return played
    cues, ends, found = played.cues, played.tables, np.zeros(len(played.cues))
    changes = NEAR_A_JUMP * np.minimum(cues['tolerance'], COARSEST_STRIKE)
    near = cues['discontinuity_margin'] <= SUSPECT * changes
    near &= (cues['status'] < MISS) & (cues['phases'] > 1) & ~cues['others']
    for i in np.flatnonzero(near):
        finest = tolerance * (FINER if ends['jaws_met'][i] > 0 else 1.0)
        (tip, cloth), places = model.stiffness, []
        for change in (-changes[i], 0.0, changes[i]):
            changed = model._replace(
                stiffness=(float(tip * (1.0 + change)), cloth), follow_through=0.0
            )
            places.append(_end(changed, normals[i : i + 1], velocities[i : i + 1], finest))
        bend = float(np.linalg.norm(places[0] - 2.0 * places[1] + places[2]))
        found[i] = bend if bend > 2.0 * finest else 0.0
    ends['error'] += found
    well = np.isin(ends['status'], (OK, INFINITE_SEQUENCE)) & (ends['run_status'] == OK)
    ends['status'][well & (found > 0.0)] = TOLERANCE_NOT_REACHED
    return played._replace(discontinuity=found)


def _end(model: StrikeModel, normal: Array, velocity: Array, tolerance: float) -> Array:
    """Find where the ball of one stroke rests on endless cloth (3,) [m]."""
    task = task_of(alone(model), normal, velocity, None, Accuracy(tolerance, checked=False))
    place: Array = run_tables(task).balls['position'][0, 0]
    return place
