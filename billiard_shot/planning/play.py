"""Strokes played and judged, by the hundred."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.motions import motions_of
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.score import score
from billiard_shot.planning.strikes import Rows, vectors_of
from billiard_shot.shot.clearance import surroundings_of
from billiard_shot.shot.on_table import states_of, strike_frozen
from billiard_shot.shot.strike import strike_batch
from billiard_shot.status import Status
from billiard_shot.table.simulate import BatchRecording, run_recorded

TOLERANCE = 1e-3  # m, of trajectories: well below what noise does
# Outcomes on which one can count; a tip that slides (MISCUE) does not always do so alike.
SOUND = (Status.OK, Status.INFINITE_SEQUENCE, Status.TOLERANCE_NOT_REACHED)


class Outcomes(NamedTuple):
    """How n strokes ended."""

    success: NDArray[np.bool_]  # (n,) whether the target was reached
    # (n,) how far from it: 0 is there; below 1, in m or so, with only the last step missing;
    # one more for every step that is missing before that
    miss: Rows
    rest: Rows  # (n, 2) m: where the cue ball ends


def play(problem: Problem, strokes: Rows) -> Outcomes:
    """Play strokes (n, 5): a, b, elevation, azimuth, speed; see `vectors_of`."""
    recording, sound = simulate_strokes(problem, strokes)
    motions = motions_of(recording)
    success, miss = score(problem, recording, motions)
    success &= sound
    miss = np.where(sound, miss, FAILED)
    return Outcomes(success, miss, recording.balls['position'][:, 0, :2])


FAILED = 9.0  # miss of strokes that cannot be played


def simulate_strokes(problem: Problem, strokes: Rows) -> tuple[BatchRecording, NDArray[np.bool_]]:
    """Play strokes on the table; return the recording, and whether each strike is a sound one."""
    scene, model = problem.scene, problem.model
    centre = np.array([*problem.cue_ball, problem.radius])
    normals, velocities = vectors_of(strokes)
    played = strike_batch(model, normals, velocities, centre, TOLERANCE, surroundings_of(scene))
    given = states_of(scene, centre, played.strikes)
    strike_frozen(model, problem.table, given, normals, velocities, played.strikes)
    sound = np.isin(played.strikes['status'], SOUND)
    return run_recorded(model.surface, problem.table, given, 0.25 * TOLERANCE), sound
