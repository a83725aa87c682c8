"""The search: candidates, refinement of the best ones, and a race under execution noise."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
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
from billiard_shot.planning.evaluate import Outcomes
from billiard_shot.planning.places import draw_places, for_each
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.runner import Runner, StoppedError
from billiard_shot.planning.statistics import sample_execution_noise, wilson_interval
from billiard_shot.planning.strikes import wrapped
from billiard_shot.planning.waypoints import combinations, Waypoint, waypoints
from billiard_shot.records import Array
from billiard_shot.scene.player import AZIMUTH

NORMAL_BUDGET = 60_000  # simulations to which the numbers below apply
MIN_EFFORT = 0.3  # share of these numbers for a small budget
CANDIDATES, CANDIDATE_SHARE = 6_000, 0.3  # of a stage: at most; and as a share of the budget
MAX_ROUTES = 24  # of each kind of route
CURVED_COUNT, CURVED_POINTS = 360, 6  # curved candidates in all; waypoints that they are for
REFINED = 40  # candidates of a stage that are refined
RACERS, FINAL_STROKES = 8, 4  # strokes that race; strokes that get held-out trials
RACE_TRIALS, MAX_RACES = 200, 5  # trials of each stroke in a race; races
SURE_SUCCESS = 0.98  # lower bound of the success at which the race ends
WINNER_TRIALS, OTHER_TRIALS = 1500, 400  # held-out trials of the winner; of each other
# Rounds, of which two must agree: minimum if a stroke is good; minimum if none is; maximum.
ROUNDS_IF_GOOD, HARD_ROUNDS, MAX_ROUNDS = 2, 3, 5
PROMISING = 0.1  # success: a stage that is worse than the best by more is not searched again
# Success probabilities below which these are tried: combinations; routes by one cushion; curved
# paths; routes by more cushions, and random strokes.
DETOURS_BELOW, CUSHIONS_BELOW, CURVES_BELOW, RANDOM_BELOW = 0.9, 0.5, 0.3, 0.1

cost_of = attrgetter('cost')

# Two strokes are alike if they differ in every component by less than the larger of these:
# standard deviations of the noise; a, b (ball radii), elevation, azimuth (rad) and speed (m/s).
ALIKE_SIGMAS = 4.0
ALIKE_DISTANCE = np.array([0.15, 0.15, 0.05, 0.01, 0.3])


class Finalist(NamedTuple):
    """A stroke with its successes in held-out trials, and the mean value of their outcomes."""

    stroke: Array
    successes: int
    trials: int
    value: float
    value_error: float  # standard error of the mean value


class Found(NamedTuple):
    """Result of a search."""

    finalists: list[Finalist]  # the winner of the race, the others by the lower end of intervals
    penalty: float  # smallest of all candidates, see `Outcomes`
    cancelled: bool  # then the finalists have the estimates so far
    converged: bool  # two searches from different random numbers agree on the success


@dataclass(slots=True)
class Stage:
    """Candidates of one kind, simulated without errors."""

    candidates: Candidates
    outcomes: Outcomes
    value: float = 0.0  # of its best stroke so far


def search(problem: Problem, runner: Runner, seed: int) -> Found:
    """
    Search until two rounds agree, the budget is spent, or the search is cancelled.

    Each round refines other candidates with other random numbers. Its stages go from straight
    paths to complicated ones, and end as soon as a stroke is good enough.
    """
    draws = np.random.default_rng(seed)
    effort = min(1.0, max(MIN_EFFORT, runner.budget / NORMAL_BUDGET))
    stages: list[Stage] = []
    makers = stage_candidates(problem, runner)
    found: list[Population] = []
    winners: list[float] = []  # value of the best stroke of each round
    nearest, converged = np.inf, False
    try:
        for number in range(MAX_ROUNDS):
            first, runner.best = len(found), 0.0
            for stage in _simulated(runner, stages, makers):
                nearest = min(nearest, float(stage.outcomes.penalty.min()))
                count = max(4, round(effort * REFINED))
                chosen = choose_candidates(stage.candidates, stage.outcomes, count, draws)
                population = population_of(
                    stage.candidates.take(chosen), stage.outcomes.take(chosen)
                )
                found.append(population)
                for better in refine(problem, runner, population, draws, effort):
                    found[-1] = better
                stage.value = max(stage.value, float(found[-1].value.max(initial=0.0)))
                if runner.left <= 0:
                    break
            best = best_of(found[first:])
            if not len(best.strokes):
                break
            winners.append(float(best.value[0]))
            samples = int(best.samples[0])
            sure = wilson_interval(winners[-1] * samples, samples)[0] > SURE_SUCCESS
            rounds = ROUNDS_IF_GOOD if max(winners) >= DETOURS_BELOW else HARD_ROUNDS
            converged = sure or (number + 1 >= rounds and _agree(winners, samples))
            if converged or runner.left <= 0:
                break
        runner.best = max(winners, default=0.0)
        runner.reserved = 0
        finalists = run_race(problem, runner, best_of(found), draws, effort)
        return Found(finalists, nearest, cancelled=False, converged=converged)
    except StoppedError:
        best = best_of(found)
        best = best.take(_distinct(problem, best.strokes)[:FINAL_STROKES])
        finalists = [
            Finalist(stroke, round(success * n), n, value, _standard_error(value, n))
            for stroke, success, value, n in zip(
                best.strokes,
                best.success.tolist(),
                best.value.tolist(),
                best.samples.tolist(),
                strict=True,
            )
        ]
        return Found(finalists, nearest, cancelled=True, converged=False)


def _agree(winners: list[float], samples: int) -> bool:
    """Whether the two best rounds found strokes with the same value."""
    second, first = sorted(winners)[-2:]
    return wilson_interval(second * samples, samples)[1] >= first


def stage_candidates(problem: Problem, runner: Runner) -> Iterator[Candidates]:
    """Yield the candidates of the stages, as far as they are needed."""
    points = waypoints(problem, 0)
    routes = [routes_to(problem, point, 0) for point in points]
    direct = sorted(chain.from_iterable(routes), key=cost_of)[:MAX_ROUTES]
    yield spread_azimuth(candidates_along(problem, direct))
    if runner.best < DETOURS_BELOW:
        pushed = [
            route for point in combinations(problem) for route in routes_to(problem, point, 0)
        ]
        pushed = sorted(pushed, key=cost_of)[:MAX_ROUTES]
        yield spread_azimuth(candidates_along(problem, pushed))
    cushions = problem.scene.table is not None
    if cushions and runner.best < CUSHIONS_BELOW:
        yield _cushion_candidates(problem, runner, ((0, 1), (1, 0)), MAX_ROUTES)
    if runner.best < CURVES_BELOW:  # late, because a curve takes several times as long
        blocked = [point for point, found in zip(points, routes, strict=True) if not found]
        yield _curved_candidates(problem, runner, blocked)
    if cushions and runner.best < RANDOM_BELOW:
        yield _cushion_candidates(problem, runner, ((0, 2), (2, 1)), 2 * MAX_ROUTES)
    tried, capacity = 0, min(CANDIDATES, max(1, round(CANDIDATE_SHARE * runner.budget)))
    while runner.left > 0 and runner.best < RANDOM_BELOW:
        yield random_candidates(problem, capacity, tried)
        tried += capacity


def _simulated(
    runner: Runner, stages: list[Stage], makers: Iterator[Candidates]
) -> Iterator[Stage]:
    """Yield the best stages of earlier rounds, and then further stages that are needed."""
    best = max((stage.value for stage in stages), default=0.0)
    yield from [stage for stage in stages if stage.value >= best - PROMISING]
    for candidates in makers:
        capacity = min(CANDIDATES, max(1, round(CANDIDATE_SHARE * runner.budget)), runner.left)
        candidates = _thinned(candidates, capacity)
        outcomes = runner.evaluate(candidates.strokes)
        count = len(outcomes.penalty)
        if count:  # fewer than there are candidates, if the time is up
            stages.append(Stage(candidates.take(np.arange(count)), outcomes))
            yield stages[-1]


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


def _curved_candidates(problem: Problem, runner: Runner, points: list[Waypoint]) -> Candidates:
    points = sorted(points, key=lambda point: point.after)[:CURVED_POINTS]
    if not points:
        return candidates_along(problem, [])
    strikes = build_strike_library(problem)
    count = CURVED_COUNT // len(points)
    curves = [curved_candidates(problem, strikes, each, count, runner.goes_on) for each in points]
    return spread_azimuth(concatenate(curves))


def _thinned(candidates: Candidates, capacity: int) -> Candidates:
    """Select at most `capacity` candidates, evenly."""
    if len(candidates.route) <= capacity:
        return candidates
    return candidates.take(np.linspace(0, len(candidates.route) - 1, capacity).astype(np.int64))


def choose_candidates(
    candidates: Candidates, outcomes: Outcomes, count: int, draws: np.random.Generator
) -> NDArray[np.int64]:
    """
    Choose candidates with a value, then those with the smallest penalty, in turn from all routes.

    Routes whose candidates have more value come first.
    """
    penalty, value = outcomes.penalty, outcomes.value
    hits = np.bincount(candidates.route, value)[candidates.route]
    order = np.lexsort((draws.permutation(len(penalty)), penalty, -value, candidates.route))
    route = candidates.route[order]
    turn = np.empty(len(penalty))  # rank of each candidate among those of its route
    turn[order] = np.arange(len(penalty)) - np.searchsorted(route, route)
    ranks = penalty, -value, -hits, turn, value == 0.0
    chosen: NDArray[np.int64] = np.lexsort(ranks)[:count]
    return chosen


def best_of(found: list[Population]) -> Population:
    """Concatenate the populations of all stages, ordered by the lower bound of the value."""
    if not found:
        strokes, numbers = np.empty((0, 5)), np.empty(0)
        nothing = strokes, strokes, numbers, numbers, numbers
        return Population(*nothing, np.empty(0, np.int64))
    population = Population(*(np.concatenate(parts) for parts in zip(*found, strict=True)))
    known = zip(population.value.tolist(), population.samples.tolist(), strict=True)
    surely = np.array([wilson_interval(part * n, n)[0] for part, n in known])
    return population.take(np.lexsort((population.penalty, -surely)))


def run_race(
    problem: Problem,
    runner: Runner,
    population: Population,
    draws: np.random.Generator,
    effort: float,
) -> list[Finalist]:
    """Let the best strokes race, then evaluate the finalists on held-out trials."""
    strokes = population.strokes[population.value > 0.0]
    strokes = strokes[_distinct(problem, strokes)[:RACERS]]
    held_out = round(effort * (WINNER_TRIALS + (FINAL_STROKES - 1) * OTHER_TRIALS))
    runner.reserved = min(held_out, runner.left // 2)
    wins, trials = np.zeros(len(strokes)), 0
    for _ in range(MAX_RACES):
        race = min(round(effort * RACE_TRIALS), runner.left // max(1, len(strokes)))
        if len(strokes) < 2 or race < 8:
            break
        noise = sample_execution_noise(problem, draws, race)
        places = draw_places(problem, draws, race)
        outcomes = _trials(runner, strokes, noise, places, exact=False)
        if len(outcomes.value) < len(strokes) * race:
            break  # the time is up
        wins += outcomes.value.reshape(-1, race).sum(axis=1)
        trials += race
        order = np.argsort(-wins, kind='stable')
        strokes, wins = strokes[order], wins[order]
        racing = _still_racing(wins, trials)
        if racing == 1:
            break
        if racing >= FINAL_STROKES:
            strokes, wins = strokes[:racing], wins[:racing]
    runner.reserved = 0
    found = []
    for place, stroke in enumerate(strokes[:FINAL_STROKES]):
        share = (WINNER_TRIALS, OTHER_TRIALS)[place > 0]
        count = min(max(1, round(effort * share)), runner.left)
        noise = sample_execution_noise(problem, draws, count)
        places = draw_places(problem, draws, count)
        outcomes = _trials(runner, stroke[np.newaxis], noise, places, exact=True)
        count = len(outcomes.value)
        if count:
            value, successes = float(outcomes.value.mean()), int(outcomes.success.sum())
            error = float(outcomes.value.std()) / count**0.5
            found.append(Finalist(stroke, successes, count, value, error))
    # The race alone decides the first place: the best of several held-out results is biased.
    others = sorted(
        found[1:], key=lambda each: -wilson_interval(each.trials * each.value, each.trials)[0]
    )
    return found[:1] + others


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
        away[:, AZIMUTH] = wrapped(away[:, AZIMUTH])
        if not (np.abs(away) < apart).all(axis=1).any():
            chosen.append(i)
    return np.array(chosen, np.int64)


def _trials(
    runner: Runner, strokes: Array, noise: Array, places: Array | None, *, exact: bool
) -> Outcomes:
    """Play each stroke (n, 5) with each of the errors (m, 5): n m outcomes, or the first ones."""
    tried = (strokes[:, np.newaxis] + noise).reshape(-1, 5)
    where = for_each(len(strokes), places)
    return runner.evaluate(tried, where, exact=exact, to_the_end=True)


def _standard_error(value: float, trials: int) -> float:
    """Bound the standard error of the mean of values from 0 to 1."""
    return float(np.sqrt(value * (1.0 - value) / trials))
