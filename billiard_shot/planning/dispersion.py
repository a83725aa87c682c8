"""Dispersion of the outcomes of a planned stroke by execution noise."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.evaluate import penalties_of, simulate_strokes
from billiard_shot.planning.places import as_struck, draw_places
from billiard_shot.planning.problem import problem_of
from billiard_shot.planning.result import RankedStroke
from billiard_shot.records import Array
from billiard_shot.scene import Noise
from billiard_shot.table.motion import POCKETED
from billiard_shot.table.task import BatchRecording

PIECES = 6  # straight lines by which a segment is approximated


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
    strokes = stroke + draw.standard_normal((count, 5)) * problem.sigmas
    places = draw_places(problem, draw, count)
    if places is not None:
        strokes = as_struck(problem, strokes, places)
    recording, usable = simulate_strokes(problem, strokes, places=places)
    penalties = penalties_of(problem, recording)
    final = recording.balls['position'][:, :, :2].copy()
    final[recording.balls['motion'] >= POCKETED] = np.nan
    moved, paths = _motions(recording)
    return Dispersion(problem.names, final, moved, paths, (penalties == 0.0) & usable)


def _motions(recording: BatchRecording) -> tuple[NDArray[np.bool_], tuple[Array, ...]]:
    """Find which balls moved (n, balls), and the paths of n cue balls (., 2) [m] as lines."""
    counts = np.diff(recording.tables['segments'], prepend=0)
    table = np.repeat(np.arange(len(counts)), counts)
    order = np.lexsort((recording.segments['ball'], table))  # stable: in the order of time
    rows, table = recording.segments[order], table[order]
    owner, time = rows['ball'], rows['time']
    duration = np.zeros(len(rows))
    goes_on = (table[1:] == table[:-1]) & (owner[1:] == owner[:-1])
    duration[:-1] = np.where(goes_on, time[1:] - time[:-1], 0.0)
    moved = np.zeros(recording.balls.shape, np.bool_)
    moved[table[duration > 0.0], owner[duration > 0.0]] = True
    cue = owner == 0
    rows, table = rows[cue], table[cue]
    dt = duration[cue, np.newaxis, np.newaxis] * np.linspace(0.0, 1.0, PIECES + 1)[:, np.newaxis]
    corners = rows['position'][:, np.newaxis, :2] + dt * (
        rows['velocity'][:, np.newaxis, :2] + 0.5 * dt * rows['acceleration'][:, np.newaxis, :2]
    )
    return moved, tuple(corners[table == i].reshape(-1, 2) for i in range(len(counts)))
