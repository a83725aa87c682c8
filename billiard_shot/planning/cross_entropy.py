"""
Refinement of strokes by the cross-entropy method.

Each iteration samples around every stroke of the population, moves the stroke to the mean of its
successful samples, and keeps the best strokes. If outcomes have values, the values are the weights
of the mean. The first iterations sample as widely as candidates may be wrong, the last ones with
the execution noise itself. The mean error of the successful samples is then the gradient of the
success probability in the metric of the noise (cross-entropy method, Rubinstein 1999; natural
evolution strategies, Wierstra 2014).
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import raise_for_clearance
from billiard_shot.planning.places import draw_places, for_each
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.runner import Runner
from billiard_shot.planning.stages import Stage
from billiard_shot.records import Array
from billiard_shot.scene.player import AZIMUTH, ELEVATION, SPEED

OFFSET_SIGMA = 0.12  # ball radii: of the offsets of candidates
ELEVATION_SIGMA = 0.02  # rad: of their elevations
SPEED_SIGMA = 0.2  # relative: of their speeds
ELITE_SHARE = 0.25  # of the samples: the best ones, if fewer succeed
# Of each iteration: scale of the candidates' sigmas (0: execution noise alone), and the samples of
# each stroke. Half of the population goes on to the next one, but at least `FEWEST`: the best
# `OF_A_ROUTE` strokes of the best routes. A route that needs accurate strokes looks bad among the
# wide errors of the first iterations, and may be the best in the end.
SCHEDULE = ((1.0, 12), (0.7, 24), (0.5, 48), (0.3, 96), (0.15, 192), (0.0, 384))
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

    def take(self, which: NDArray[np.int64]) -> 'Population':
        """Select some of the strokes."""
        fields: Any = (field[which] for field in self)
        return Population(*fields)


def population_of(stage: Stage, chosen: NDArray[np.int64]) -> Population:
    """Make a population of some candidates of a stage."""
    candidates, outcomes = stage.candidates.take(chosen), stage.outcomes.take(chosen)
    strokes = candidates.strokes
    sigma = np.empty_like(strokes)
    sigma[:, :2], sigma[:, ELEVATION] = stage.width * OFFSET_SIGMA, ELEVATION_SIGMA
    sigma[:, AZIMUTH] = candidates.spread
    sigma[:, SPEED] = stage.width * SPEED_SIGMA * strokes[:, SPEED]
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
    outcomes = runner.evaluate(flat, for_each(count, places))
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
    blocked = np.isnan(strokes).any(axis=1)
    strokes[blocked] = population.strokes[blocked]
    return Population(
        strokes,
        population.sigma,
        value.mean(axis=1),
        success.mean(axis=1),
        best,
        np.full(count, samples, np.int64),
        population.route,
    )
