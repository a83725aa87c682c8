"""What noise makes of a planned stroke: where the balls end, time after time."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.chance import errors
from billiard_shot.planning.motions import motions_of
from billiard_shot.planning.play import simulate_strokes
from billiard_shot.planning.problem import problem_of
from billiard_shot.planning.result import RankedStroke
from billiard_shot.planning.score import score
from billiard_shot.planning.strikes import Rows
from billiard_shot.scene import Noise
from billiard_shot.table.motion import POCKETED


class Cloud(NamedTuple):
    """Outcomes of n strokes that were all meant to be the same one."""

    names: tuple[str, ...]  # of the balls, the cue ball first
    rests: Rows  # (n, balls, 2) m: where each ends; NaN: in a pocket or off the table
    moved: NDArray[np.bool_]  # (n, balls) whether it went anywhere
    paths: tuple[Rows, ...]  # (., 2) m each: ways of the cue ball
    success: NDArray[np.bool_]  # (n,) whether the target was reached


def cloud_of(planned: RankedStroke, noise: Noise, count: int, seed: int = 1) -> Cloud:
    """
    Play a planned stroke with noise.

    Parameters
    ----------
    planned : RankedStroke
    noise : Noise
    count : int
        How often.
    seed : int
        Of the errors.

    """
    problem = problem_of(planned.scene, planned.target, planned.limits, noise)
    stroke = np.array(planned.stroke.offsets)
    draw = np.random.default_rng(seed)
    recording, sound = simulate_strokes(problem, stroke + errors(problem, draw, count))
    motions = motions_of(recording)
    success, _ = score(problem, recording, motions)
    rests = recording.balls['position'][:, :, :2].copy()
    rests[recording.balls['motion'] >= POCKETED] = np.nan
    moved = np.zeros(rests.shape[:2], np.bool_)
    goes = motions.duration > 0.0
    moved[motions.table[goes], motions.ball[goes]] = True
    cue = motions.of(motions.ball == 0)
    paths = tuple(cue.corners[cue.table == i].reshape(-1, 2) for i in range(count))
    return Cloud(problem.names, rests, moved, paths, success & sound)
