"""predict_within_noise(): many strokes, as accurate as the errors of the player call for."""

from collections.abc import Iterator, Mapping
from itertools import chain
import math
from typing import Any

from numpy.typing import ArrayLike

from billiard_shot.planning.noises import accuracy_within, noise_of
from billiard_shot.planning.strike_map import bounds_of, Cell, Fit, fit_cell, Maps
from billiard_shot.records import Array
from billiard_shot.scene import Noise, Scene, SceneLike
from billiard_shot.shot.play import play
from billiard_shot.shot.setting import setting_of
from billiard_shot.shot.stroke import playable_offsets, read_rows, vectors_of
from billiard_shot.shot.stroke_batch import StrokeBatch
from billiard_shot.table.table_states import TableStates
from billiard_shot.table.threads import in_threads


def predict_within_noise(
    scene: SceneLike,
    offsets: ArrayLike,
    noise: str | Noise | Mapping[str, Any] | None = None,
    workers: int | None = None,
) -> StrokeBatch:
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
    strokes = playable_offsets(read_rows('offsets', offsets, 5))
    sigmas = noise_of(scene, noise).sigmas(scene.ball.radius)
    return play_within_noise(scene, strokes, sigmas, workers=workers)


def play_within_noise(
    scene: Scene,
    strokes: Array,
    sigmas: Array,
    tables: TableStates | None = None,
    workers: int | None = None,
) -> StrokeBatch:
    """
    Play strokes, mapping their strikes where maps are accurate enough.

    Parameters
    ----------
    scene : Scene
    strokes : (n, 5) float array
        See `vectors_of`; NaN where there is no stroke.
    sigmas : (5,) float array
        Standard deviations of a, b (ball radii), elevation, azimuth (rad) and speed (m/s).
    tables, workers
        As of `play`.

    """
    setting = setting_of(scene)
    slower_than = math.inf if tables is not None else setting.reaching
    maps = Maps(setting.model, bounds_of(sigmas), slower_than)

    def fitted(cells: list[Cell]) -> Iterator[Fit]:
        def fit(part: slice) -> list[Fit]:
            return [fit_cell(setting.model, cell) for cell in cells[part]]

        return chain.from_iterable(in_threads(fit, len(cells), workers))

    mapped, accuracy = maps.mapped(strokes, fitted), accuracy_within(sigmas)
    return play(scene, *vectors_of(strokes), tables, accuracy, mapped, workers)
