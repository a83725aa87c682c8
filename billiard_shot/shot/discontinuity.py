"""
Where a law is discontinuous: strikes with two outcomes, however accurately they are solved.

Law `energetic` ends a contact at a finite force, so that a contact that ends just before it would
have been compressed anew and one that is just compressed anew lead to different motions.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.laws import ENERGETIC
from billiard_shot.records import Array
from billiard_shot.shot.accuracy import Accuracy, strike_tolerance
from billiard_shot.shot.on_table import task_of
from billiard_shot.shot.setting import alone
from billiard_shot.shot.strike_model import StrikeModel
from billiard_shot.status import MISS
from billiard_shot.table.task import run_tables

# Tolerances of the strike, relative to the stiffness: near enough to be on a jump.
NEAR_A_JUMP = 10.0
COARSEST_STRIKE = 1e-6  # tolerance of a strike
SUSPECT = 1e4  # changes of the stiffness: margins of decisions that they may turn are smaller


def discontinuities_of_law(
    model: StrikeModel,
    normals: Array,
    velocities: Array,
    cues: NDArray[np.void],
    tolerance: float,
) -> Array:
    """
    Find how far the resting places of strokes on endless cloth jump (n,) [m]; 0: not at all.

    A strike that comes close to a decision is solved again with the tip a little stiffer and a
    little softer, by as much as its accuracy is. The changes of a continuous outcome cancel. If
    more than the tolerance is left, the outcome jumps in between.

    Parameters
    ----------
    model : StrikeModel
    normals, velocities : (n, 3) float arrays
    cues : (n,) array of CueRecord
        After these strokes. Those in which the ball reached others do not count.
    tolerance : float
        Of the trajectories [m].

    """
    found = np.zeros(len(cues))
    if model.law != ENERGETIC:  # the others have next to none
        return found
    near = cues['discontinuity_margin'] < SUSPECT * NEAR_A_JUMP * COARSEST_STRIKE
    if not near.any():
        return found
    speeds = np.linalg.norm(velocities, axis=1)
    near &= (cues['status'] < MISS) & (cues['phases'] > 1) & ~cues['others']
    for i in np.flatnonzero(near):
        accuracy = min(strike_tolerance(model, float(speeds[i]), tolerance), COARSEST_STRIKE)
        change = NEAR_A_JUMP * accuracy
        if cues['discontinuity_margin'][i] > SUSPECT * change:
            continue
        tip, cloth = model.stiffness
        ends = []
        for factor in (1.0 - change, 1.0, 1.0 + change):
            changed = model._replace(stiffness=(tip * factor, cloth), follow_through=0.0)
            ends.append(_end(changed, normals[i : i + 1], velocities[i : i + 1], tolerance))
        bend = float(np.linalg.norm(ends[0] - 2.0 * ends[1] + ends[2]))
        found[i] = bend if bend > 2.0 * tolerance else 0.0
    return found


def _end(model: StrikeModel, normal: Array, velocity: Array, tolerance: float) -> Array:
    """Find where the ball of one stroke rests on endless cloth (3,) [m]."""
    task = task_of(alone(model), normal, velocity, None, Accuracy(tolerance, checked=False))
    place: Array = run_tables(task).balls['position'][0, 0]
    return place
