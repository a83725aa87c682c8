"""How execution noise disperses the outcomes of a planned stroke."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.evaluate import penalties_of, simulate_strokes
from billiard_shot.planning.paths import paths_of
from billiard_shot.planning.problem import problem_of
from billiard_shot.planning.result import RankedStroke
from billiard_shot.planning.statistics import sample_execution_noise
from billiard_shot.planning.strikes import Array
from billiard_shot.scene import Noise
from billiard_shot.table.motion import POCKETED


class Dispersion(NamedTuple):
    """Outcomes of n noisy executions of one planned stroke."""

    names: tuple[str, ...]  # of the balls, the cue ball first
    final_positions: Array  # (n, balls, 2) m; NaN if the ball is in a pocket or off the table
    moved: NDArray[np.bool_]  # (n, balls) whether the ball moved
    paths: tuple[Array, ...]  # n paths of the cue ball (., 2) [m]
    success: NDArray[np.bool_]  # (n,) whether the target was reached


def sample_outcomes(planned: RankedStroke, noise: Noise, count: int, seed: int = 1) -> Dispersion:
    """
    Simulate a planned stroke with execution noise.

    Parameters
    ----------
    planned : RankedStroke
    noise : Noise
    count : int
        Number of executions.
    seed : int
        Of the random errors.

    """
    problem = problem_of(planned.scene, planned.target, planned.limits, noise)
    stroke = np.array(planned.stroke.offsets)
    draw = np.random.default_rng(seed)
    errors = sample_execution_noise(problem, draw, count)
    recording, usable = simulate_strokes(problem, stroke + errors)
    penalties = penalties_of(problem, recording)
    final = recording.balls['position'][:, :, :2].copy()
    final[recording.balls['motion'] >= POCKETED] = np.nan
    paths = paths_of(recording)
    return Dispersion(problem.names, final, paths.moved, paths.cue, (penalties == 0.0) & usable)
