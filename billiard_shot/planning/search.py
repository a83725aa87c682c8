"""The search: candidates, refinement of the best ones, and a race under execution noise."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import chain
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.candidates import (
    Candidates,
    candidates_along,
    concatenate,
    random_candidates,
    Route,
    routes_to,
    spread_azimuth,
)
from billiard_shot.planning.cross_entropy import Population, population_of, refine
from billiard_shot.planning.curved_paths import build_strike_library, curved_candidates
from billiard_shot.planning.limits import AZIMUTH
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.runner import Runner, StoppedError
from billiard_shot.planning.statistics import sample_execution_noise, wilson_interval
from billiard_shot.planning.strikes import Array
from billiard_shot.planning.waypoints import Waypoint, waypoints

NORMAL_BUDGET = 20_000  # simulations to which the numbers below apply
CANDIDATE_SHARE = 0.3  # of the budget, for the candidates of a stage
MAX_ROUTES = 24  # of each kind of route
CURVED_COUNT, CURVED_POINTS = 360, 6  # curved candidates in all; waypoints that they are for
REFINED = 36  # candidates of a stage that are refined
RACERS, FINALISTS = 8, 4  # strokes that race; strokes that get held-out trials
RACE_TRIALS, MAX_RACES = 128, 6  # trials of each stroke in a race; races
SURE_SUCCESS = 0.98  # lower bound of the success at which the race ends
WINNER_TRIALS, OTHER_TRIALS = 800, 200  # held-out trials of the winner; of each other
# Below these success probabilities: routes by one cushion; routes by more, and random strokes.
CUSHIONS_BELOW, RANDOM_BELOW = 0.5, 0.1

cost_of = attrgetter('cost')

# Two strokes are alike if they differ in every component by less than the larger of these:
# standard deviations of the noise; a, b (ball radii), elevation, azimuth (rad) and speed (m/s).
ALIKE_SIGMAS = 4.0
ALIKE_DISTANCE = np.array([0.15, 0.15, 0.05, 0.01, 0.3])


class Finalist(NamedTuple):
    """A stroke with its successes in held-out trials."""

    stroke: Array
    successes: int
    trials: int


def search(problem: Problem, runner: Runner, seed: int) -> tuple[list[Finalist], float, bool]:
    """
    Search until the budget is spent, the best stroke is clear, or the search is cancelled.

    Returns
    -------
    finalists : list of Finalist
        The best first. If the search was cancelled, with the estimates so far.
    penalty : float
        Smallest penalty of all candidates, see `Outcomes`.
    cancelled : bool

    """
    draws = np.random.default_rng(seed)
    effort = min(1.0, max(0.25, runner.budget / NORMAL_BUDGET))
    found: list[Population] = []
    nearest = np.inf
    try:
        for stage in _stages(problem, runner):
            candidates = stage()
            candidates = candidates.take(np.arange(len(candidates.route))[: runner.left])
            if not len(candidates.route):
                continue
            penalty = runner.evaluate(candidates.strokes).penalty
            nearest = min(nearest, float(penalty.min()))
            chosen = _choose(candidates, penalty, max(4, round(effort * REFINED)), draws)
            found.append(population_of(candidates.take(chosen), penalty[chosen]))
            for better in refine(problem, runner, found[-1], draws, effort):
                found[-1] = better
            if runner.left <= 0:
                break
        runner.reserved = 0
        return _race(problem, runner, _best(found), draws, effort), nearest, False
    except StoppedError:
        best = _best(found)
        best = best.take(_distinct(problem, best.strokes)[:FINALISTS])
        known = zip(best.strokes, best.success, best.samples.tolist(), strict=True)
        return [Finalist(stroke, round(part * n), n) for stroke, part, n in known], nearest, True


def _stages(problem: Problem, runner: Runner) -> Iterator[Callable[[], Candidates]]:
    """Yield the stages of the search, each a function that makes candidates."""
    capacity = max(1, round(CANDIDATE_SHARE * min(runner.budget, NORMAL_BUDGET)))

    def usual() -> Candidates:
        points = waypoints(problem, 0)
        routes = [routes_to(problem, point, 0) for point in points]
        blocked = [point for point, found in zip(points, routes, strict=True) if not found]
        direct = sorted(chain.from_iterable(routes), key=cost_of)[:MAX_ROUTES]
        parts = [spread_azimuth(candidates_along(problem, direct))]
        return _thinned(
            concatenate([*parts, *_curved_candidates(problem, runner, blocked)]), capacity
        )

    def cushions() -> Candidates:
        return _thinned(
            _cushion_candidates(problem, runner, ((0, 1), (1, 0)), MAX_ROUTES), capacity
        )

    def more() -> Candidates:
        return _thinned(
            _cushion_candidates(problem, runner, ((0, 2), (2, 1)), 2 * MAX_ROUTES), capacity
        )

    yield usual
    if problem.scene.table is not None:
        if runner.best < CUSHIONS_BELOW:
            yield cushions
        if runner.best < RANDOM_BELOW:
            yield more
    tried = 0
    while runner.left > 0 and runner.best < RANDOM_BELOW:
        yield partial(random_candidates, problem, capacity, tried)
        tried += capacity


def _cushion_candidates(
    problem: Problem, runner: Runner, cushions: Sequence[tuple[int, int]], count: int
) -> Candidates:
    """Make candidates along the `count` best routes for each pair of cushions, (after, before)."""
    chosen: list[Route] = []
    for after, before in cushions:
        routes: list[Route] = []
        for point in waypoints(problem, after):
            runner.poll()
            routes += routes_to(problem, point, before)
        chosen += sorted(routes, key=cost_of)[:count]
    return spread_azimuth(candidates_along(problem, chosen))


def _curved_candidates(
    problem: Problem, runner: Runner, points: list[Waypoint]
) -> list[Candidates]:
    points = sorted(points, key=lambda point: point.after)[:CURVED_POINTS]
    if not points:
        return []
    strikes, found = build_strike_library(problem), []
    for point in points:
        runner.poll()
        curved = curved_candidates(problem, strikes, point, CURVED_COUNT // len(points))
        found.append(spread_azimuth(curved))
    return found


def _thinned(candidates: Candidates, capacity: int) -> Candidates:
    """Select at most `capacity` candidates, evenly."""
    if len(candidates.route) <= capacity:
        return candidates
    return candidates.take(np.linspace(0, len(candidates.route) - 1, capacity).astype(np.int64))


def _choose(
    candidates: Candidates, penalty: Array, count: int, draws: np.random.Generator
) -> NDArray[np.int64]:
    """
    Choose successful candidates, then those with the smallest penalty, in turn from all routes.

    Routes with more successful candidates come first.
    """
    hits = np.bincount(candidates.route, penalty == 0.0)[candidates.route]
    order = np.lexsort((draws.permutation(len(penalty)), penalty, candidates.route))
    route = candidates.route[order]
    turn = np.empty(len(penalty))  # rank of each candidate among those of its route
    turn[order] = np.arange(len(penalty)) - np.searchsorted(route, route)
    chosen: NDArray[np.int64] = np.lexsort((penalty, -hits, turn, penalty > 0.0))[:count]
    return chosen


def _best(found: list[Population]) -> Population:
    """Concatenate the populations of all stages, ordered by the lower bound of the success."""
    if not found:
        nothing = np.empty((0, 5)), np.empty((0, 5)), np.empty(0), np.empty(0)
        return Population(*nothing, np.empty(0, np.int64))
    population = Population(*(np.concatenate(parts) for parts in zip(*found, strict=True)))
    known = zip(population.success.tolist(), population.samples.tolist(), strict=True)
    surely = np.array([wilson_interval(part * n, n)[0] for part, n in known])
    return population.take(np.lexsort((population.penalty, -surely)))


def _race(
    problem: Problem,
    runner: Runner,
    population: Population,
    draws: np.random.Generator,
    effort: float,
) -> list[Finalist]:
    """Let the best strokes race, then evaluate the finalists on held-out trials."""
    strokes = population.strokes[population.success > 0.0]
    strokes = strokes[_distinct(problem, strokes)[:RACERS]]
    held_out = round(effort * (WINNER_TRIALS + (FINALISTS - 1) * OTHER_TRIALS))
    runner.reserved = min(held_out, runner.left // 2)
    wins, trials = np.zeros(len(strokes)), 0
    for _ in range(MAX_RACES):
        race = min(round(effort * RACE_TRIALS), runner.left // max(1, len(strokes)))
        if len(strokes) < 2 or race < 8:
            break
        noise = sample_execution_noise(problem, draws, race)
        wins += _count_successes(problem, runner, strokes, noise)
        trials += race
        order = np.argsort(-wins, kind='stable')
        strokes, wins = strokes[order], wins[order]
        racing = _still_racing(wins, trials)
        if racing == 1:
            break
        if racing >= FINALISTS:
            strokes, wins = strokes[:racing], wins[:racing]
    runner.reserved = 0
    found = []
    for place, stroke in enumerate(strokes[:FINALISTS]):
        count = min(round(effort * (OTHER_TRIALS if place else WINNER_TRIALS)), runner.left)
        if count:
            noise = sample_execution_noise(problem, draws, count)
            successes = int(_count_successes(problem, runner, stroke[np.newaxis], noise)[0])
            found.append(Finalist(stroke, successes, count))
    return found[:1] + sorted(found[1:], key=lambda each: -each.successes / each.trials)


def _still_racing(wins: Array, trials: int) -> int:
    """Count the strokes, sorted by wins, that may still be the best; 1 if one is sure."""
    low, _ = wilson_interval(wins[0], trials)
    if low > SURE_SUCCESS:
        return 1
    return sum(wilson_interval(each, trials)[1] >= low for each in wins.tolist())


def _distinct(problem: Problem, strokes: Array) -> NDArray[np.int64]:
    """Find the strokes (n, 5) that are not alike to an earlier one; return their indices."""
    apart = np.maximum(ALIKE_SIGMAS * problem.sigmas, ALIKE_DISTANCE)
    chosen: list[int] = []
    for i in range(len(strokes)):
        away = strokes[i] - strokes[chosen]
        away[:, AZIMUTH] = np.remainder(away[:, AZIMUTH] + np.pi, 2.0 * np.pi) - np.pi
        if not (np.abs(away) < apart).all(axis=1).any():
            chosen.append(i)
    return np.array(chosen, np.int64)


def _count_successes(problem: Problem, runner: Runner, strokes: Array, noise: Array) -> Array:
    """Count the successes of each stroke under the same errors."""
    tried = (strokes[:, np.newaxis] + noise).reshape(-1, 5)
    success = runner.evaluate(tried).success.reshape(len(strokes), len(noise))
    return success.sum(axis=1).astype(float)
