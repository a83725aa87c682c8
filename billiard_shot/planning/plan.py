"""plan(): the stroke most likely to reach a target; candidates(): the strokes it begins with."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
import math
import os
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.problem import (
    check_clearance,
    Limits,
    limits_of,
    Problem,
    problem_of,
    Target,
)
from billiard_shot.planning.result import PlanResult, RankedStroke, why_not_straight
from billiard_shot.planning.runner import Progress, Runner, SupportsSubmit, ValueFunction
from billiard_shot.planning.score import MAX_DISTANCE_PENALTY
from billiard_shot.planning.search import Found, NORMAL_BUDGET, search
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.planning.stages import next_stage, Stage
from billiard_shot.planning.statistics import quasi_random
from billiard_shot.planning.targets import Break, Pot, target_of
from billiard_shot.planning.within_noise import noise_of
from billiard_shot.records import Array
from billiard_shot.scene import Noise, Robot, Scene, SceneLike
from billiard_shot.scene.equipment import Table
from billiard_shot.scene.fields import positive, whole
from billiard_shot.scene.placement import CUE_BALL, head_string, no_place, Place
from billiard_shot.scene.player import AZIMUTH
from billiard_shot.status import Status
from billiard_shot.table.run.results import POCKET_NAMES
from billiard_shot.table.run.states import TableStates

IN_HAND_PLACES = 'anywhere', 'kitchen'
TRIED = 1500  # places that are rated
PLACE_SPACING = 0.15  # m, at least, between the places that are chosen
NEAREST = 0.15  # m to the ball: from nearer the cue may hit the cue ball twice
ALIKE = 0.01  # chance: among places that differ by less, the one with the shortest ways is better
# Places of breaks: table lengths behind the head string; table widths beside the middle, at most.
BREAK_BEHIND, BREAK_BESIDE = 0.02, 0.4


def places_in_hand(
    scene: Scene, target: Target, limits: Limits, noise: Noise, place: str, count: int
) -> list[tuple[float, float]]:
    """
    Choose places of the cue ball (x, y) [m], the best first.

    For a pot, those from which a direct shot pots the ball. For a break, places in the kitchen,
    from the middle of the head string to the side.

    Parameters
    ----------
    scene : Scene
    target : Target
    limits : Limits
    noise : Noise
    place : str
        `anywhere` on the table, or in the `kitchen`: behind the head string.
    count : int
        Largest number of places; they are at least `PLACE_SPACING` from each other.

    Raises
    ------
    ValueError
        If `place` is not in `IN_HAND_PLACES`, or the target is neither a pot nor a break.

    """
    if place not in IN_HAND_PLACES:
        raise ValueError(f'place must be {" or ".join(IN_HAND_PLACES)}, got {place!r}')
    if not isinstance(target, Pot | Break) or scene.table is None:
        name = type(target).__name__.lower()
        raise ValueError(f'place needs the target pot or break, got the target {name}')
    others = scene.object_balls
    table, radius = scene.table, scene.ball.radius
    is_break = isinstance(target, Break)
    points = _along_head_string(table, count) if is_break else places_all_over(table, place)
    free = [(x, y) for x, y in points.tolist() if not no_place(table, x, y, radius, others)]
    if isinstance(target, Break):
        return free
    legal = [
        name
        for name in others
        if target.concerns(name)
        and name not in limits.keep
        and (not limits.first_contact or name in limits.first_contact)
    ]
    found = shots(scene, cue_ball_at(np.array(free), others, radius), legal, noise)
    wanted = np.isin(found.pocket, [POCKET_NAMES.index(name) for name in target.pocket])
    wanted &= limits.allows_azimuth(found.offsets[:, AZIMUTH])
    order = best_in_hand(found)
    chosen: list[tuple[float, float]] = []
    for k in order[wanted[order]].tolist():
        here = free[found.table[k]]
        if all(math.dist(here, other) >= PLACE_SPACING for other in chosen):
            chosen.append(here)
        if len(chosen) == count:
            break
    return chosen


def _along_head_string(table: Table, count: int) -> Array:
    """List places (n, 2) [m] a little behind the head string, from its middle to the side."""
    x, y = head_string(table) - BREAK_BEHIND * table.length, BREAK_BESIDE * table.width
    return np.column_stack([np.full(count, x), np.linspace(0.0, y, count)])


def best_in_hand(direct: DirectShots) -> NDArray[np.int64]:
    """List direct shots, the best first, without those whose cue ball is too near to the ball."""
    rounded = np.round(direct.chance / ALIKE)
    order = np.lexsort((direct.distance + direct.way, -rounded))
    return order[direct.distance[order] >= NEAREST]


def cue_ball_at(places: Array, others: Mapping[str, Place], radius: float) -> TableStates:
    """Make a table for each place (n, 2) [m] of the cue ball, with the other balls as they lie."""
    position = np.full((len(places), 1 + len(others), 3), radius)
    position[:, 0, :2] = places.reshape(-1, 2)
    position[:, 1:, :2] = np.array(list(others.values())).reshape(-1, 2)
    return TableStates((CUE_BALL, *others), position)


def places_all_over(table: Any, place: str) -> Array:
    """
    List places (n, 2) [m], all over the table or the kitchen, that are tried for the cue ball.

    Parameters
    ----------
    table : Table or State
        Anything with a length and a width [m].
    place : str
        One of `IN_HAND_PLACES`.

    """
    low = -0.5 * np.array([table.length, table.width])
    high = -low
    if place == 'kitchen':
        high[0] = head_string(table)
    points: Array = low + (high - low) * quasi_random(TRIED, 2)
    return points


def cue_ball_all_over(
    table: Any, others: Mapping[str, Place], radius: float, count: int
) -> TableStates:
    """Make tables with the cue ball at the first places (count) all over that are free."""
    places = places_all_over(table, 'anywhere')[:count]
    away = np.hypot(*(places[:, np.newaxis] - np.array([*others.values()])).T).min(axis=0)
    return cue_ball_at(places[away > 2.0 * radius], others, radius)


NARROW = 0.1  # width of the interval of a best stroke that may be called converged
USUAL_SECONDS = 1.0  # s: time of a search for which somebody waits
PLACES_TRIED = 4  # of a cue ball in hand, for breaks and if it has to come to rest at a place


def plan(
    scene: SceneLike,
    target: Target | Mapping[str, Any],
    noise: str | Noise | Mapping[str, Any] | None = None,
    budget: int = NORMAL_BUDGET,
    seed: int = 1,
    constraints: Mapping[str, Any] | Robot | None = None,
    progress: Callable[[Progress], object] | None = None,
    cancel: Callable[[], bool] | None = None,
    executor: Executor | SupportsSubmit | None = None,
    seconds: float | None = None,
    place: str | None = None,
    value: ValueFunction | None = None,
) -> PlanResult:
    """
    Find the stroke most likely to reach a target, given execution noise, limits and obstacles.

    The same scene, target, noise, budget, seed and constraints give the same result with any
    executor, unless the search is cancelled.

    Parameters
    ----------
    scene : Scene, str or Path
        With the positions of all balls; its sections `robot` and `noise` describe the player. A
        name or path is read as by `Scene.load`.
    target : mapping or Target
        `{'rest': (x, y), 'radius': r}`, `{'pass': (x, y), 'radius': r}`,
        `{'gate': ((x1, y1), (x2, y2))}`, `{'hit': ball}` with an optional `direction` or `at`,
        `{'pot': name, list or 'any', 'pocket': name, list or 'any'}` with an optional `leave` and
        `radius`, `{'safe': balls, 'against': balls, 'chance': p}`, `{'break': balls, 'pots': n}`;
        or an object of the classes in targets.py. In m, frame `table`.
    noise : str, Noise or mapping, optional
        `tournament`, `none`, a level of people such as `fargo_500`, or the standard deviations of
        a `Noise`; by default those of the scene.
    budget : int
        Largest number of simulated strokes, at least 1. The search ends earlier if the best
        stroke is clear.
    seed : int
        Of all random numbers, at least 0.
    constraints : mapping or Robot, optional
        Fields that replace those of the scene's section `robot`; `first_contact`: the ball that
        the cue ball must meet first, or a list of balls of which it must meet one first; `keep`:
        a ball that must not be pocketed, or a list.
    progress : callable, optional
        Called with a `Progress` every few milliseconds.
    cancel : callable, optional
        Called every few milliseconds; if it returns True, the search ends with the best result
        so far.
    executor : optional
        Evaluates the strokes; it has the method `submit` of the executors of
        `concurrent.futures`. By default threads on all cores.
    seconds : float, optional
        Time after which the search ends with its best result [s], above 0, from its first
        strokes on; by default the budget alone ends it. A search that the time ends is not
        reproducible.
    place : str, optional
        The cue ball is in hand, and the plan says where to put it: `anywhere` on the table, or in
        the `kitchen` behind the head string. Only for targets that pot a ball, at the places with
        the best direct shots, and for breaks, at places along the head string. The places share
        the budget.
    value : callable, optional
        Value of outcomes: it takes a `TableBatch` of n runs, and returns (n,) numbers from 0 to 1,
        such as chances to win from the tables at rest. The plan is then the stroke with the best
        mean value, whether or not it reaches the target, to which the search looks for ways. A
        stroke that cannot be played, or whose tip slides, has the value 0. Threads call it at the
        same time.

    Returns
    -------
    PlanResult
        `status` says how the search ended.

    Raises
    ------
    ValueError
        If the request is invalid, or the limits leave the cue no clearance; the message names the
        fields to change. If `value` returns numbers of another shape or range.

    """
    scene = Scene.load(scene)
    spread = noise_of(scene, noise)
    wanted = target_of(scene, target)
    limits = limits_of(scene, constraints, spread)
    budget, seed = whole('budget', budget, 1), whole('seed', seed, 0)
    if seconds is not None:
        seconds = positive('seconds', seconds, 's')
    begin = perf_counter()

    def search_at(scene: Scene, parts: int) -> tuple[float, PlanResult]:
        """Search at the cue ball of a scene, in a part of the budget; also return the value."""
        problem = checked_problem(scene, wanted, limits, spread)
        threads = ThreadPoolExecutor(os.cpu_count() or 1)
        try:
            runner = Runner(
                problem,
                max(1, budget // parts),
                executor or threads,
                progress,
                cancel,
                seconds and seconds / parts,
                value,
            )
            found = search(problem, runner, seed)
        finally:
            # after a cancellation, do not wait for running tasks
            threads.shutdown(wait=False, cancel_futures=True)
        return found.value, _result(problem, runner, found, begin)

    if place is None:
        return search_at(scene, 1)[1]
    count = 1 if isinstance(wanted, Pot) and wanted.leave is None else PLACES_TRIED
    places = places_in_hand(scene, wanted, limits, spread, place, count)
    if not places:
        text = f'place: no direct shot pots the ball from {place}'
        return PlanResult(Status.NO_PLAN, text, (), 0, perf_counter() - begin, spread)
    results = []
    for there in places:
        placed = replace(scene, balls={**scene.balls, CUE_BALL: there})
        value_there, result = search_at(placed, len(places))
        results.append((value_there, replace(result, place=there)))
    return replace(
        max(results, key=lambda found: found[0] if found[1].best else -1.0)[1],
        simulations=sum(each.simulations for _, each in results),
        wall_time=perf_counter() - begin,
    )


def _result(problem: Problem, runner: Runner, found: Found, begin: float) -> PlanResult:
    """Make the result of a search, which began at a time [s]."""
    ranking = tuple(each for each in found.finalists if each.value > 0.0)
    if ranking and ranking[0].width > NARROW:
        found = found._replace(converged=False)
    status, message = _outcome(ranking, found, runner, problem.target)
    if status == Status.NO_PLAN and isinstance(problem.target, Pot) and not runner.late:
        why = why_not_straight(problem.scene, problem.target, problem.limits.keep)
        message = '; '.join(filter(None, [message, why]))
    return PlanResult(
        status,
        message,
        ranking,
        runner.simulations,
        perf_counter() - begin,
        problem.noise,
        converged=found.converged,
    )


def checked_problem(scene: Scene, wanted: Target, limits: Limits, spread: Noise) -> Problem:
    """
    Make a planning problem.

    Raises
    ------
    ValueError
        If the limits leave the cue no clearance, balls never rest, or no ball may be potted.

    """
    check_clearance(scene, limits)
    problem = problem_of(scene, wanted, limits, spread)
    surface = problem.model.surface
    if not (surface.rolling_resistance > 0.0 and surface.spin_deceleration > 0.0):
        raise ValueError(
            'scene: balls that never rest cannot be planned; rolling_resistance and '
            'spin_deceleration of the cloth must be above 0, and the effects roll and '
            'spin_decay on'
        )
    if isinstance(wanted, Pot) and not problem.balls:
        raise ValueError('constraints: keep: all balls of the target must stay on the table')
    return problem


def _outcome(
    ranking: tuple[RankedStroke, ...], found: Found, runner: Runner, target: Target
) -> tuple[Status, str]:
    simulations = runner.simulations
    if found.cancelled:
        so_far = _summary(ranking[0]) if ranking else 'no stroke was found so far'
        text = f'cancelled after {simulations} simulations: {so_far}'
        return Status.CANCELLED, '; '.join([text, *_untried(found)])
    if ranking:
        notes = [_summary(ranking[0])]
        if not found.converged:
            what = 'more time' if runner.is_timed else 'a larger budget'
            notes += [f'not converged: {what} may find a better stroke', *_untried(found)]
        return Status.OK, '; '.join(notes)
    if not simulations:
        return Status.NO_PLAN, 'seconds: the time was up before a stroke was tried'
    detail = ''
    if found.penalty == 0.0:
        detail = '; strokes that reached it did not repeat under noise'
        if not runner.left:
            detail = '; a stroke reached it, but was not repeated: take a larger budget'
    elif found.penalty < MAX_DISTANCE_PENALTY:
        detail = f'; the nearest stroke misses by {target.miss_in_words(found.penalty)}'
    within = f'{simulations} simulations' + ', until the time was up' * runner.late
    text = f'no stroke reaches the target in {within}{detail}'
    return Status.NO_PLAN, '; '.join([text, *_untried(found)])


def _untried(found: Found) -> list[str]:
    """Say which kinds of candidates the search did not come to, if there are any."""
    return [f'not tried: {", ".join(found.untried)}'] if found.untried else []


def _summary(best: RankedStroke) -> str:
    success = f'{best.kind}: success {best.estimate}'
    if best.value != best.success:
        success += f', value {best.value:.3f} (standard error {best.value_error:.3f})'
    return '; '.join(filter(None, [success, best.warning]))


CANDIDATE_BUDGET = 6_000  # simulated strokes


@dataclass(frozen=True, slots=True, eq=False)
class CandidateStrokes:
    """
    Strokes that may reach a target, the nearest first.

    Attributes
    ----------
    offsets : (n, 5) float array
        a, b, elevation, azimuth, speed, as of `Stroke.from_offsets`.
    penalty : (n,) float array
        0 if the stroke reaches the target without errors. Otherwise how far it is from that: one
        for every step that is missing, and below one for the distance that is left.

    """

    offsets: Array
    penalty: Array

    def __len__(self) -> int:
        """Return the number of strokes."""
        return len(self.penalty)

    def __repr__(self) -> str:
        return f'CandidateStrokes({len(self)}, of which {(self.penalty == 0.0).sum()} reach it)'


def candidates(
    scene: SceneLike,
    target: Target | Mapping[str, Any],
    noise: str | Noise | Mapping[str, Any] | None = None,
    budget: int = CANDIDATE_BUDGET,
    constraints: Mapping[str, Any] | Robot | None = None,
) -> CandidateStrokes:
    """
    List strokes that may reach a target, simulated once, without errors.

    They differ in path, speed and spin. Straight paths come first; combinations, cushions and
    curves follow only if no stroke so far has reached the target.

    Parameters
    ----------
    scene, target, noise, constraints
        As of `plan`.
    budget : int
        Largest number of simulated strokes, at least 1.

    Raises
    ------
    ValueError
        As of `plan`.

    """
    scene = Scene.load(scene)
    spread = noise_of(scene, noise)
    wanted = target_of(scene, target)
    budget = whole('budget', budget, 1)
    problem = checked_problem(scene, wanted, limits_of(scene, constraints, spread), spread)
    stages: list[Stage] = []
    with ThreadPoolExecutor(os.cpu_count() or 1) as threads:
        runner = Runner(problem, budget, threads)
        runner.reserved = 0
        best = 0.0
        while stage := next_stage(problem, runner, stages, best, share=1.0):
            best = float(stage.outcomes.success.any())
    strokes = np.concatenate([stage.candidates.strokes for stage in stages])
    penalty = np.concatenate([stage.outcomes.penalty for stage in stages])
    order = np.argsort(penalty, kind='stable')
    return CandidateStrokes(strokes[order], penalty[order])
