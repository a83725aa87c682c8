"""plan(): which stroke reaches a target, and how surely."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
import os
from time import perf_counter
from typing import Any

import numpy as np

from billiard_shot import machine_code
from billiard_shot.planning.limits import check_room, limits_of
from billiard_shot.planning.problem import problem_of
from billiard_shot.planning.result import PlanResult, RankedStroke
from billiard_shot.planning.runner import Progress, Runner, Submits
from billiard_shot.planning.search import NORMAL_BUDGET, search
from billiard_shot.planning.targets import Target, target_of
from billiard_shot.scene import Noise, Robot, Scene
from billiard_shot.scene.checks import read
from billiard_shot.scene.mistakes import InputError
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status

# Of the computer pool tournaments, see `Noise`; and none, for a player who never errs.
NOISES = {'tournament': Noise(), 'none': Noise(0.0, 0.0, 0.0, 0.0, 0.0)}


def plan(
    scene: Scene,
    target: Target | Mapping[str, Any],
    noise: str | Noise | Mapping[str, Any] | None = None,
    budget: int = NORMAL_BUDGET,
    seed: int = 1,
    constraints: Mapping[str, Any] | Robot | None = None,
    progress: Callable[[Progress], object] | None = None,
    cancel: Callable[[], bool] | None = None,
    executor: Executor | Submits | None = None,
) -> PlanResult:
    """
    Search the stroke that most surely reaches a target.

    The same scene, target, noise, budget, seed and constraints give the same result, whatever
    plays the strokes, unless the search is cancelled.

    Parameters
    ----------
    scene : Scene
        With the balls where they lie; its sections `robot` and `noise` say who plays.
    target : mapping or Target
        `{'rest': (x, y), 'radius': r}`, `{'pass': (x, y), 'radius': r}`,
        `{'gate': ((x1, y1), (x2, y2))}`, `{'hit': ball}` with perhaps `direction` or `at`,
        `{'pot': ball, 'pocket': name, list or 'any'}` with perhaps `leave` and `radius`; or an
        object of the classes of targets.py. In m, frame `table`.
    noise : str, Noise or mapping, optional
        `tournament`, `none`, or the standard deviations of a `Noise`; by default the scene's.
    budget : int
        Most strokes that are simulated, at least 1. The search ends sooner if the best is clear.
    seed : int
        Of all that is random, at least 0.
    constraints : mapping or Robot, optional
        Fields of the scene's section `robot` that are other than there, and `first_contact`: the
        ball that the cue ball has to meet first.
    progress : callable, optional
        Called with a `Progress` every some ms.
    cancel : callable, optional
        Asked every some ms whether to end; then the best so far is the result.
    executor : optional
        What plays the strokes, with the method `submit` of executors of `concurrent.futures`; by
        default threads on all cores.

    Returns
    -------
    PlanResult
        `status` says how it ended. What makes no sense gives INVALID_REQUEST and a `message`
        that says what to change.

    """
    begin = perf_counter()
    try:
        spread = _noise(scene, noise)
        wanted = target_of(scene, target)
        limits = limits_of(scene, constraints, spread)
        _whole('budget', budget, 1)
        _whole('seed', seed, 0)
        check_room(scene, limits)
    except ValueError as error:
        return PlanResult(Status.INVALID_REQUEST, str(error), (), 0, 0.0, scene.noise)
    machine_code.require()
    problem = problem_of(scene, wanted, limits, spread)
    threads = ThreadPoolExecutor(os.cpu_count() or 1)
    try:
        runner = Runner(problem, budget, executor or threads, progress, cancel)
        finalists, miss, cancelled = search(problem, runner, seed)
    finally:
        # strokes that are being played when it is cancelled are not waited for
        threads.shutdown(wait=False, cancel_futures=True)
    ranking = tuple(
        RankedStroke(
            scene,
            wanted,
            limits,
            Stroke.from_offsets(*finalist.stroke.tolist()),
            finalist.successes,
            finalist.trials,
        )
        for finalist in finalists
        if finalist.successes
    )
    status, message = _verdict(ranking, miss, cancelled, runner.played)
    return PlanResult(status, message, ranking, runner.played, perf_counter() - begin, spread)


def _noise(scene: Scene, noise: str | Noise | Mapping[str, Any] | None) -> Noise:
    if noise is None:
        return scene.noise
    if isinstance(noise, Noise):
        return noise
    if isinstance(noise, str) and noise in NOISES:
        return NOISES[noise]
    if isinstance(noise, Mapping):
        try:
            return read(Noise, noise)
        except InputError as error:
            raise InputError(error.mistakes, 'noise') from None
    raise ValueError(
        f'noise: {noise!r} is not allowed; it must be {", ".join(NOISES)} or a mapping of '
        'standard deviations'
    )


def _whole(name: str, value: object, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ValueError(
            f'{name}: {value!r} is not allowed; it must be a whole number, at least {least}'
        )


def _verdict(
    ranking: tuple[RankedStroke, ...], miss: float, cancelled: bool, played: int
) -> tuple[Status, str]:
    if cancelled:
        so_far = _chance(ranking[0]) if ranking else 'nothing was found so far'
        return Status.CANCELLED, f'cancelled after {played} simulations: {so_far}'
    if ranking:
        return Status.OK, _chance(ranking[0])
    steps = (
        '' if miss > 1.0 or miss == 0.0 else f'; the nearest stroke misses by {1e3 * miss:.0f} mm'
    )
    steps = '; strokes that reach it do so by luck only' if miss == 0.0 else steps
    return Status.NO_PLAN, f'no stroke that reaches the target in {played} simulations{steps}'


def _chance(best: RankedStroke) -> str:
    low, high = best.interval
    return (
        f'{best.kind}: {100.0 * best.success:.0f} % of strokes reach the target '
        f'(95 % sure: {100.0 * low:.0f} to {100.0 * high:.0f} %)'
    )
