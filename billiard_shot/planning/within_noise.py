"""predict_within_noise(): many strokes, as accurate as the errors of the player call for."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot import machine_code
from billiard_shot.planning.evaluate import reaching_speed_in, start_strokes, Started
from billiard_shot.planning.limits import limits_of
from billiard_shot.planning.mapped_starts import all_solved, Mapped, SOLVED
from billiard_shot.planning.noises import noise_of
from billiard_shot.planning.problem import Problem, problem_of
from billiard_shot.planning.strike_map import bounds_of, Cell, Fit, fit_cell, Maps
from billiard_shot.planning.targets import Rest
from billiard_shot.records import Array
from billiard_shot.scene import Noise, Scene, SceneLike
from billiard_shot.scene.values import as_floats
from billiard_shot.shot.on_table import names_of
from billiard_shot.shot.stroke import playable_offsets
from billiard_shot.status import Status
from billiard_shot.table.simulate import (
    batch_of,
    BatchRecording,
    in_threads,
    INTERPRETED_AT_MOST,
    joined,
    run_tables,
    TableBatch,
)
from billiard_shot.table.words import count_in_words

NO_TARGET = Rest(rest=(0.0, 0.0))


@dataclass(frozen=True, eq=False)
class NoisyBatch:
    """
    Predictions of n strokes at the accuracy of a player's errors.

    Attributes
    ----------
    velocity, spin : (n, 3) float arrays
        Of the cue ball at the end of the strike [m/s] and [rad/s].
    status : (n,) uint16 array
        Status, as `predict` gives it; but the accuracy of a stroke is not checked.
    mapped : (n,) bool array
        Whether the strike comes from a map, see `predict_within_noise`; else it is solved.
    double_hit : (n,) bool array
        Whether the cue hit the ball again.
    run : TableBatch
        All balls.

    """

    velocity: NDArray[np.float64]
    spin: NDArray[np.float64]
    status: NDArray[np.uint16]
    mapped: NDArray[np.bool_]
    double_hit: NDArray[np.bool_]
    run: TableBatch

    def __repr__(self) -> str:
        return f'NoisyBatch({count_in_words(self.status, "stroke", self.miscue)})'

    @property
    def miscue(self) -> NDArray[np.bool_]:
        """Whether the tip still slid when it left the ball (n,); never if it is mapped."""
        return self.run.miscue


def predict_within_noise(
    scene: SceneLike,
    offsets: ArrayLike,
    noise: str | Noise | Mapping[str, Any] | None = None,
    workers: int | None = None,
) -> NoisyBatch:
    """
    Predict many strokes at once, as accurately as the errors of the player call for.

    Where at least 24 strokes are alike, their strikes come from a polynomial that was fitted to
    exact strikes, if held-out strikes agree with it within a fifth of the player's errors. Other
    strikes are solved. Rebounds of lying balls are interpolated: 95 % of them err by less than
    0.5 % of the ball's speed. Trajectories err by at most the displacement that the error of the
    azimuth causes over 2 m, or 1 mm. Single strokes can differ from `predict`, whose answer is
    exact; shares of many strokes agree, see docs/batches.md.

    Parameters
    ----------
    scene : Scene, str or Path
    offsets : (n, 5) array_like
        As of `predict_batch`.
    noise : str, Noise or mapping, optional
        As of `plan`.
    workers : int, optional
        Threads; by default as many as there are cores.

    Raises
    ------
    ValueError
        If an argument makes no sense.

    """
    scene = Scene.load(scene)
    rows = as_floats(offsets)
    if rows.ndim != 2 or rows.shape[1] != 5:
        raise ValueError(f'offsets must be of shape (n, 5), got {rows.shape}')
    strokes = playable_offsets(rows)
    spread = noise_of(scene, noise)
    if len(strokes) > INTERPRETED_AT_MOST:
        machine_code.require()
    problem = problem_of(scene, NO_TARGET, limits_of(scene, None, spread), spread)
    mapped = _mapped(problem, strokes, workers)

    def play(part: slice) -> tuple[Started, BatchRecording]:
        started = start_strokes(problem, strokes[part], mapped.part(part), coarse=True)
        return started, run_tables(started.task)

    parts = in_threads(play, len(strokes), workers) or [play(slice(0, 0))]
    run = batch_of(joined([recording for _, recording in parts]), names_of(scene))
    started = [each for each, _ in parts]
    status = np.concatenate([each.status for each in started]).astype(np.uint16)
    starts = np.concatenate([each.task.starts[:, 0] for each in started])
    played = status < Status.MISS
    ended = np.isin(status, (Status.OK, Status.INFINITE_SEQUENCE)) & (run.status != Status.OK)
    status[ended] = run.status[ended]
    repeated = np.concatenate([each.cues['hits'] > 1 for each in started])
    return NoisyBatch(
        velocity=starts['velocity'],
        spin=starts['spin'],
        status=status,
        mapped=(mapped.number != SOLVED) & played,
        double_hit=played & (repeated | (run.cue_hits > 0)),
        run=run,
    )


def _mapped(problem: Problem, strokes: Array, workers: int | None) -> Mapped:
    """Map strokes, fitting missing cells."""
    maps = Maps(problem.model, bounds_of(problem.sigmas), reaching_speed_in(problem))
    if not maps.applies:
        return all_solved(len(strokes))

    def fitted(cells: list[Cell]) -> Iterator[Fit]:
        def fit(part: slice) -> list[Fit]:
            return [fit_cell(problem.model, cell) for cell in cells[part]]

        return chain.from_iterable(in_threads(fit, len(cells), workers))

    return maps.mapped(strokes, fitted)
