"""Simulation of many strokes at once, and their penalties."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.problem import Problem
from billiard_shot.planning.score import score
from billiard_shot.planning.segments import segments_of
from billiard_shot.planning.strikes import Array, vectors_of
from billiard_shot.shot.clearance import surroundings_of
from billiard_shot.shot.on_table import states_of, strike_frozen
from billiard_shot.shot.strike import strike_batch
from billiard_shot.status import Status
from billiard_shot.table.simulate import BatchRecording, run_recorded

TOLERANCE = 1e-3  # m, of trajectories: well below the effect of execution noise
# A planned stroke may end with these. MISCUE is not among them: a sliding tip is not repeatable.
USABLE_STATUSES = (Status.OK, Status.INFINITE_SEQUENCE, Status.TOLERANCE_NOT_REACHED)
INFEASIBLE_PENALTY = 9.0  # of strokes that cannot be played


class Outcomes(NamedTuple):
    """How n strokes ended."""

    success: NDArray[np.bool_]  # (n,) whether the target was reached
    # (n,) 0 if the target was reached; below 1 if only the last step is missing, then about the
    # remaining distance in m; one more for every earlier step that is missing
    penalty: Array
    final_position: Array  # (n, 2) m, of the cue ball


def evaluate_strokes(problem: Problem, strokes: Array) -> Outcomes:
    """Simulate strokes (n, 5): a, b, elevation, azimuth, speed; see `vectors_of`."""
    recording, usable = simulate_strokes(problem, strokes)
    segments = segments_of(recording)
    success, penalty = score(problem, recording, segments)
    success &= usable
    penalty = np.where(usable, penalty, INFEASIBLE_PENALTY)
    return Outcomes(success, penalty, recording.balls['position'][:, 0, :2])


def simulate_strokes(problem: Problem, strokes: Array) -> tuple[BatchRecording, NDArray[np.bool_]]:
    """Simulate strokes on the table; return the recording, and whether each strike is usable."""
    scene, model = problem.scene, problem.model
    centre = np.array([*problem.cue_ball, problem.radius])
    normals, velocities = vectors_of(strokes)
    played = strike_batch(model, normals, velocities, centre, TOLERANCE, surroundings_of(scene))
    states = states_of(scene, centre, played.strikes)
    strike_frozen(model, problem.table, states, normals, velocities, played.strikes)
    usable = np.isin(played.strikes['status'], USABLE_STATUSES)
    return run_recorded(model.surface, problem.table, states, 0.25 * TOLERANCE), usable
