"""success_map(): the success probability of a pot, over the places of the cue ball."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from billiard_shot.planning.plan import plan
from billiard_shot.planning.targets import Pot, target_of
from billiard_shot.records import Array
from billiard_shot.scene import Noise, Scene, SceneLike
from billiard_shot.scene.errors import must_be, must_be_one_of
from billiard_shot.scene.fields import whole
from billiard_shot.scene.placement import CUE_BALL, no_place

USUAL_GRID = 36, 18
MAP_BUDGET = 2000  # strokes to simulate for each place


@dataclass(frozen=True, slots=True, eq=False)
class SuccessMap:
    """
    Success probability of a pot, with the best stroke found from each place of the cue ball.

    Attributes
    ----------
    scene : Scene
    ball : str
        The ball that is potted, from its place in the scene.
    x, y : (columns,), (rows,) float arrays
        Centres of equal cells that fill the area of ball centres, along length and width [m].
    success, low, high : (rows, columns) float arrays
        Fraction of held-out trials that pot the ball, and its 95 % interval (Wilson): 0, 0 and 1
        without a stroke, NaN where the cue ball cannot lie.

    """

    scene: Scene
    ball: str
    x: Array
    y: Array
    success: Array
    low: Array
    high: Array


def success_map(
    scene: SceneLike,
    ball: str,
    grid: tuple[int, int] = USUAL_GRID,
    *,
    pocket: str | Sequence[str] = 'any',
    noise: str | Noise | None = None,
    budget: int = MAP_BUDGET,
    seed: int = 1,
    executor: Executor | None = None,
    report: Callable[[int], object] = lambda done: None,
) -> SuccessMap:
    """
    Plan a pot from each place of the cue ball; the other balls of the scene stay.

    The same arguments give the same map with any executor.

    Parameters
    ----------
    scene : Scene, str or Path
    ball : str
    grid : (int, int)
        Number of places along the length and along the width of the table.
    pocket : str or sequence of str
        Names of the pockets into which the ball may fall, or `any`.
    noise, budget, seed
        As of `plan`, the budget for each place.
    executor : Executor, optional
        Plans from several places at once: one of `concurrent.futures`, or that of a Dask client
        (`get_executor()`). By default the places follow each other, each on all cores.
    report : callable
        Called with the number of places done so far.

    Raises
    ------
    ValueError
        If the ball is not in the scene, if the table has no pockets, or if no place is free.

    """
    scene = Scene.load(scene)
    if not scene.object_balls:
        raise ValueError(f'ball {must_be("in the scene, which has only the cue ball", ball)}')
    if ball not in scene.object_balls:
        raise ValueError(f'ball {must_be_one_of(scene.object_balls, ball)}')
    target = target_of(scene, {'pot': ball, 'pocket': pocket})
    assert isinstance(target, Pot)
    assert scene.table is not None  # a pot without pockets is refused
    counts = [whole(f'grid[{i}]', each, 1) for i, each in enumerate(grid)]
    sizes = scene.table.length - 2 * scene.ball.radius, scene.table.width - 2 * scene.ball.radius
    x, y = (
        size * ((np.arange(count) + 0.5) / count - 0.5)
        for size, count in zip(sizes, counts, strict=True)
    )
    places = [(i, (float(a), float(b))) for i, (b, a) in enumerate((b, a) for b in y for a in x)]
    free = [
        each
        for each in places
        if not no_place(scene.table, *each[1], scene.ball.radius, scene.object_balls)
    ]
    if not free:
        raise ValueError(f'grid {must_be("one with a place for the cue ball", grid)}')
    work = partial(_chance, scene, target, noise, budget, seed, executor is None)
    found = np.full((len(places), 3), np.nan)
    chances = map(work, free) if executor is None else executor.map(work, free)
    for done, ((number, _), chance) in enumerate(zip(free, chances, strict=True), 1):
        found[number] = chance
        report(done)
    success, low, high = found.T.reshape(3, len(y), len(x))
    return SuccessMap(scene, ball, x, y, success, low, high)


def _chance(
    scene: Scene,
    target: Pot,
    noise: str | Noise | None,
    budget: int,
    seed: int,
    on_all_cores: bool,
    numbered: tuple[int, tuple[float, float]],
) -> tuple[float, float, float]:
    """Success of the best stroke from a numbered place, and its 95 % interval."""
    number, place = numbered
    there = replace(scene, balls={**scene.balls, CUE_BALL: place}, rack=None)
    executor = None if on_all_cores else _Immediately()
    try:
        best = plan(there, target, noise, budget, seed + number, executor=executor).best
    except ValueError:  # the cue has no clearance
        best = None
    return (best.success, *best.interval) if best else (0.0, 0.0, 1.0)


class _Immediately:
    """Executor that runs each task at once, on the calling thread."""

    def submit(self, work: Any, /, *arguments: Any) -> Future[Any]:
        """Run a task."""
        future: Future[Any] = Future()
        future.set_result(work(*arguments))
        return future
