"""The search: candidates, refinement of the best ones, and a race under execution noise."""

from __future__ import annotations

from collections.abc import Iterator
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.numerics.vectors import wrapped
from billiard_shot.planning.problem import draw_places, for_each, Problem, raise_for_clearance
from billiard_shot.planning.result import RankedStroke
from billiard_shot.planning.runner import Outcomes, Runner, StoppedError
from billiard_shot.planning.stages import next_stage, Stage, untried
from billiard_shot.planning.statistics import wilson_interval, Z95
from billiard_shot.records import Array
from billiard_shot.scene.player import AZIMUTH, ELEVATION, SPEED
from billiard_shot.shot.stroke import Stroke

NORMAL_BUDGET = 60_000  # simulations to which the numbers below apply
MIN_EFFORT = 0.3  # share of these numbers for a small budget or a short time
RACERS, FINAL_STROKES = 6, 4  # strokes that race; strokes that get held-out trials
RACE_TRIALS = (200, 200, 400)  # of each stroke that still races, in the rounds of a race
SURE_SUCCESS = 0.95  # lower bound of the success at which no further round follows
AS_GOOD = 0.01  # of success: strokes that have less than the best by more are not as good
# Half of the width of the interval that held-out trials give the winner, and each other stroke;
# numbers of these trials that may be fewer only if budget or time do not allow them; and the
# smallest number of the winner's, even if the time is up.
HALF_WIDTHS, FEWEST_TRIALS, LEAST_TRIALS = (0.03, 0.06), (200, 100), 100
LATER_SHARE = 0.6  # of the candidates of a stage that are refined again
MAX_ROUNDS = 5  # fewer if one finds no better stroke than those before
PROMISING = 0.1  # success: a stage that is worse than the best by more is not searched again

# Two strokes are alike if they differ in every component by less than the larger of these:
# standard deviations of the noise; a, b (ball radii), elevation, azimuth (rad) and speed (m/s).
ALIKE_SIGMAS = 4.0
ALIKE_DISTANCE = np.array([0.15, 0.15, 0.05, 0.01, 0.3])


class Found(NamedTuple):
    """Result of a search."""

    # The winner of the race, then the others by the lower end of their intervals.
    finalists: list[RankedStroke]
    value: float  # of the first one, in the trials by which it was chosen
    penalty: float  # smallest of all candidates, see `Outcomes`
    cancelled: bool  # then the finalists have the estimates so far
    converged: bool  # the success is nearly 1, or a search from other candidates found no larger
    untried: tuple[str, ...]  # kinds of candidates that were called for, but not tried


def search(problem: Problem, runner: Runner, seed: int) -> Found:
    """
    Search until a round finds nothing better, the budget is spent, or the search is cancelled.

    Each round refines other candidates with other random numbers. Its stages go from straight
    paths to complicated ones, and end as soon as a stroke is good enough.
    """
    draws = np.random.default_rng(seed)
    stages: list[Stage] = []
    found: list[Population] = []
    winners: list[float] = []  # value of the best stroke of each round
    nearest, converged, cancelled = np.inf, False, False
    try:
        for _ in range(MAX_ROUNDS):
            first, best = len(found), 0.0
            again = _promising(stages)
            while stage := again.pop(0) if again else next_stage(problem, runner, stages, best):
                nearest = min(nearest, float(stage.outcomes.penalty.min()))
                effort = effort_of(runner)
                population = population_of(stage, choose_candidates(stage, effort, draws))
                found.append(population)
                for better in refine(problem, runner, population, draws, effort):
                    found[-1] = better
                if found[-1] is not population:
                    value = float(found[-1].value[0])
                    best = max(best, value)
                    runner.note(found[-1].strokes[0], value)
                stage.value = max(stage.value, float(found[-1].value.max(initial=0.0)))
                if runner.left <= 0:
                    break
            winner = best_of(found[first:])
            if not len(winner.strokes):
                break
            winners.append(float(winner.value[0]))
            samples = int(winner.samples[0])
            sure = wilson_interval(winners[-1] * samples, samples)[0] > SURE_SUCCESS
            before = wilson_interval(max(winners[:-1], default=0.0) * samples, samples)[1]
            converged = sure or (len(winners) > 1 and winners[-1] <= before)
            if converged or runner.left <= 0:
                break
        runner.best = max(winners, default=0.0)
        runner.reserved = 0
        strokes, values = run_race(problem, runner, best_of(found), draws, effort_of(runner))
        finalists = state_success(problem, runner, strokes, values, draws, effort_of(runner))
    except StoppedError:
        converged, cancelled, ended = False, True, best_of(found)
        ended = ended.take(_distinct(problem, ended.strokes)[:FINAL_STROKES])
        finalists, values = [], ended.value
        for i, n in enumerate(ended.samples.tolist()):
            mean, successes = float(ended.value[i]), round(ended.success[i] * n)
            error = (mean * (1.0 - mean) / n) ** 0.5  # no values have a larger one
            finalists.append(_ranked(problem, ended.strokes[i], successes, n, mean, error))
    value, left_out = max(values[:1], default=0.0), untried(stages, runner.best)
    return Found(finalists, value, nearest, cancelled, converged, left_out)


def _promising(stages: list[Stage]) -> list[Stage]:
    """Select the stages whose candidates are refined again in a further round."""
    best = max((stage.value for stage in stages), default=0.0)
    return [stage for stage in stages if len(stage.chosen) and stage.value >= best - PROMISING]


def choose_candidates(
    stage: Stage, effort: float, draws: np.random.Generator
) -> NDArray[np.int64]:
    """
    Choose candidates with a value, then those with the smallest penalty, in turn from all routes.

    Those that were not chosen in earlier rounds come first, and routes whose candidates have more
    value. The stage notes what was chosen.
    """
    route, (_, penalty, value) = stage.candidates.route, stage.outcomes
    hits = np.bincount(route, value)[route]
    again = stage.chosen & (value > 0.0)
    order = np.lexsort((draws.permutation(len(penalty)), penalty, -value, again))
    ranks = penalty, -value, -hits, turns(route, order), again, value == 0.0
    share = LATER_SHARE if stage.chosen.any() else 1.0
    count = max(4, round(share * effort * stage.kind.refined))
    chosen: NDArray[np.int64] = np.lexsort(ranks)[:count]
    stage.chosen[chosen] = True
    return chosen


OFFSET_SIGMA = 0.12  # ball radii: of the offsets of candidates
ELEVATION_SIGMA = 0.02  # rad: of their elevations
SPEED_SIGMA = 0.2  # relative: of their speeds
ELITE_SHARE = 0.25  # of the samples: the best ones, if fewer succeed
# Of each iteration: scale of the candidates' sigmas (0: execution noise alone), and the samples of
# each stroke. Half of the population goes on to the next one, but at least `FEWEST`: the best
# `OF_A_ROUTE` strokes of the best routes. A route that needs accurate strokes looks bad among the
# wide errors of the first iterations, and may be the best in the end.
SCHEDULE = ((1.0, 12), (0.7, 24), (0.5, 48), (0.3, 96), (0.15, 96), (0.0, 192))
FEWEST, OF_A_ROUTE = 4, 2


class Population(NamedTuple):
    """Strokes that are refined, with estimates from their last samples."""

    strokes: Array  # (n, 5)
    sigma: Array  # (n, 5) standard deviations of the errors of the candidates
    value: Array  # (n,) mean value of the samples: the share that succeeded, if there is no other
    success: Array  # (n,) share of the samples that succeeded
    penalty: Array  # (n,) mean penalty of the best samples
    samples: NDArray[np.int64]  # (n,) number of these samples
    route: NDArray[np.int64]  # (n,) of its candidate, see `Candidates`

    def take(self, which: NDArray[np.int64]) -> Population:
        """Select some of the strokes."""
        fields: Any = (field[which] for field in self)
        return Population(*fields)


def population_of(stage: Stage, chosen: NDArray[np.int64]) -> Population:
    """Make a population of some candidates of a stage."""
    candidates, outcomes = stage.candidates.take(chosen), stage.outcomes.take(chosen)
    strokes = candidates.strokes
    sigma = np.empty_like(strokes)
    sigma[:, :2], sigma[:, ELEVATION] = stage.kind.width * OFFSET_SIGMA, ELEVATION_SIGMA
    sigma[:, AZIMUTH] = candidates.spread
    sigma[:, SPEED] = stage.kind.width * SPEED_SIGMA * strokes[:, SPEED]
    success, once = outcomes.success.astype(float), np.ones(len(strokes), np.int64)
    penalty, route = outcomes.penalty, candidates.route
    return Population(strokes, sigma, outcomes.value, success, penalty, once, route)


def refine(
    problem: Problem,
    runner: Runner,
    population: Population,
    draw: np.random.Generator,
    effort: float,
) -> Iterator[Population]:
    """Run the iterations that the budget allows; yield the population after each, best first."""
    for sigma_scale, samples in SCHEDULE:
        count = max(4, round(effort * samples))
        if runner.left < len(population.strokes) * count:
            population = population.take(_order(population)[: max(1, runner.left // count)])
        if runner.left < count or not len(population.strokes):
            break
        normal, places = draw.standard_normal((count, 5)), draw_places(problem, draw, count)
        population = _iteration(problem, runner, population, normal, places, sigma_scale)
        population = population.take(_order(population))
        yield population
        goes_on = max(FEWEST, len(population.strokes) // 2)
        groups = turns(population.route, np.arange(len(population.route))) // OF_A_ROUTE
        population = population.take(np.argsort(groups, kind='stable')[:goes_on])


def turns(route: NDArray[np.int64], order: NDArray[np.int64]) -> NDArray[np.int64]:
    """Count, for each of n strokes in an order, the strokes of its route that come before it."""
    by_route = order[np.argsort(route[order], kind='stable')]
    sorted_routes = route[by_route]
    turn = np.empty(len(route), np.int64)
    turn[by_route] = np.arange(len(route)) - np.searchsorted(sorted_routes, sorted_routes)
    return turn


def _order(population: Population) -> NDArray[np.int64]:
    order: NDArray[np.int64] = np.lexsort((population.penalty, -population.value))
    return order


def _iteration(
    problem: Problem,
    runner: Runner,
    population: Population,
    normal: Array,
    places: Array | None,
    sigma_scale: float,
) -> Population:
    """Sample around each stroke, with the same random numbers for all, and move the stroke."""
    count, samples = len(population.strokes), len(normal)
    sigma = np.hypot(problem.sigmas, sigma_scale * population.sigma)
    tried = population.strokes[:, np.newaxis] + sigma[:, np.newaxis] * normal
    flat = tried.reshape(-1, 5)
    flat = problem.limits.clip(flat) if sigma_scale > 0.0 else flat
    outcomes = runner.evaluate(flat, for_each(count, places), each=samples)
    if len(outcomes.success) < len(flat):
        return population  # the time is up
    penalty = outcomes.penalty.reshape(count, samples)
    value = outcomes.value.reshape(count, samples)
    success = outcomes.success.reshape(count, samples)
    order = np.lexsort((penalty, -value))
    nearest = order[:, : max(2, round(ELITE_SHARE * samples))]
    low = value.min(axis=1)
    weights = value - np.where(low < value.max(axis=1), low, 0.0)[:, np.newaxis]
    few = np.count_nonzero(weights, axis=1) < nearest.shape[1]
    weights[few] = 0.0
    weights[np.flatnonzero(few)[:, np.newaxis], nearest[few]] = 1.0
    moved = np.einsum('is,isk->ik', weights, tried) / weights.sum(axis=1, keepdims=True)
    best = np.take_along_axis(penalty, nearest, axis=1).mean(axis=1)
    strokes = raise_for_clearance(problem.scene, problem.limits, problem.limits.clip(moved))
    # Samples that all fail do not move a stroke that has succeeded before: a few of them, with
    # wide errors, tell little. Its earlier samples then count too.
    stays = (population.value > 0.0) & ~value.any(axis=1)
    unmoved = stays | np.isnan(strokes).any(axis=1)
    strokes[unmoved] = population.strokes[unmoved]
    before = np.where(stays, population.samples, 0)
    share = before / (before + samples)
    return Population(
        strokes,
        population.sigma,
        value.mean(axis=1) + share * population.value,
        success.mean(axis=1) + share * population.success,
        best,
        before + samples,
        population.route,
    )


def best_of(found: list[Population]) -> Population:
    """Concatenate the populations of all stages, ordered by the lower bound of the value."""
    if not found:
        strokes, numbers = np.empty((0, 5)), np.empty(0)
        nothing, counts = (strokes, strokes, numbers, numbers, numbers), np.empty(0, np.int64)
        return Population(*nothing, counts, counts)
    population = Population(*(np.concatenate(parts) for parts in zip(*found, strict=True)))
    known = zip(population.value.tolist(), population.samples.tolist(), strict=True)
    surely = np.array([wilson_interval(part * n, n)[0] for part, n in known])
    return population.take(np.lexsort((population.penalty, -surely)))


def effort_of(runner: Runner) -> float:
    """Share of the numbers above that budget and time allow for."""
    return min(1.0, max(MIN_EFFORT, runner.scope / NORMAL_BUDGET))


def run_race(
    problem: Problem,
    runner: Runner,
    population: Population,
    draws: np.random.Generator,
    effort: float,
) -> tuple[Array, Array]:
    """
    Let the best strokes (n, 5) race, and return them with their values (n,).

    The first is the slowest of the best ones; if the runner has a `value`, the best. Strokes that
    are surely worse than the best one, under the same errors, drop out.
    """
    population = population.take(np.flatnonzero(population.value > 0.0))
    population = population.take(_distinct(problem, population.strokes)[:RACERS])
    strokes, success = population.strokes, population.value
    runner.reserved = min(FINAL_STROKES * max(FEWEST_TRIALS), runner.left // 2)
    values = np.empty((len(strokes), 0))  # of the strokes that still race, in all their trials
    for most in RACE_TRIALS:
        racing, race = len(values), min(round(effort * most), runner.left // max(1, len(values)))
        if racing < 2 or race < 8:
            break
        outcomes = _trials(problem, runner, draws, strokes[:racing], race, exact=False)
        if len(outcomes.value) < racing * race:
            break  # the time is up
        values = np.hstack([values, outcomes.value.reshape(-1, race)])
        success[:racing] = values.mean(axis=1)
        behind = values[success[:racing].argmax()] - values  # with the same errors
        error = Z95 * behind.std(axis=1) / values.shape[1] ** 0.5
        surely = behind.mean(axis=1) > error
        order = np.lexsort((-success[:racing], surely))
        strokes[:racing], success[:racing] = strokes[order], success[order]
        values = values[order[: racing - np.count_nonzero(surely)]]
        if (error - behind.mean(axis=1)).max() < AS_GOOD:
            break  # none is better by more
    runner.reserved = 0
    if runner.value is None and len(strokes):
        as_good = success[: len(values)] >= success[0] - AS_GOOD
        first = np.where(as_good, strokes[: len(values), SPEED], np.inf).argmin()
        order = np.r_[first, np.delete(np.arange(len(strokes)), first)]
        strokes, success = strokes[order], success[order]
    return strokes, success


def state_success(
    problem: Problem,
    runner: Runner,
    strokes: Array,
    value: Array,
    draws: np.random.Generator,
    effort: float,
) -> list[RankedStroke]:
    """
    Evaluate strokes (n, 5) with values (n,) on held-out trials.

    The first one stays the first: the best of several such results is larger than its success.
    """
    found: list[RankedStroke] = []
    for place, stroke in enumerate(strokes[:FINAL_STROKES]):
        variance, half = value[place] * (1.0 - value[place]), HALF_WIDTHS[place > 0]
        needed = max(FEWEST_TRIALS[place > 0], effort * variance * (Z95 / half) ** 2)
        runner.granted = 0 if found else LEAST_TRIALS
        count = min(round(needed), runner.left)
        outcomes = _trials(problem, runner, draws, stroke[np.newaxis], count, exact=True)
        count = len(outcomes.value)
        if count:
            mean, successes = float(outcomes.value.mean()), int(outcomes.success.sum())
            error = float(outcomes.value.std()) / count**0.5
            found.append(_ranked(problem, stroke, successes, count, mean, error))
    return found[:1] + sorted(found[1:], key=attrgetter('surely'), reverse=True)


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
    problem: Problem,
    runner: Runner,
    draws: np.random.Generator,
    strokes: Array,
    count: int,
    *,
    exact: bool,
) -> Outcomes:
    """Play strokes (n, 5) with `count` errors, the same for all, or the first of these trials."""
    errors = draws.standard_normal((count, 5)) * problem.sigmas
    places = for_each(len(strokes), draw_places(problem, draws, count))
    tried = (strokes[:, np.newaxis] + errors).reshape(-1, 5)
    return runner.evaluate(tried, places, exact=exact, to_the_end=True, each=count)


def _ranked(
    problem: Problem, stroke: Array, successes: int, trials: int, value: float, error: float
) -> RankedStroke:
    planned = Stroke.from_offsets(*stroke.tolist())
    return RankedStroke(
        problem.scene,
        problem.target,
        problem.limits,
        planned,
        problem.noise.commanded(planned, problem.radius),
        successes,
        trials,
        value=value,
        value_error=error,
    )
