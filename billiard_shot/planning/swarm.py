"""
Strokes that get better: sample around each, follow what succeeds, and keep those that do best.

The samples of a round are spread more at first, as widely as a guess may be wrong, and in the end
exactly as the noise spreads real strokes. Then the mean error of those that succeed is the
gradient of the chance of success, in the metric of the noise: following it leads to the middle of
what succeeds (cross-entropy method, Rubinstein 1999; natural evolution strategies, Wierstra 2014).
"""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.guesses import Guesses
from billiard_shot.planning.limits import AZIMUTH, ELEVATION, raised, SPEED
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.runner import Runner
from billiard_shot.planning.strikes import Rows

OFFSETS = 0.12  # ball radii, how widely offsets are sought at first
RAISE = 0.02  # rad, and elevations
FASTER = 0.2  # and speeds, parts of them
ELITE = 0.25  # part of the samples that is followed while few succeed
# How wide each round is between noise alone (0) and all that a guess may be wrong (1), which part
# of the strokes goes on after it, and how many samples there are.
ROUNDS = ((1.0, 0.6, 24), (0.5, 0.6, 32), (0.2, 0.6, 40), (0.0, 0.6, 64), (0.0, 1.0, 96))


class Swarm(NamedTuple):
    """Strokes, and what is known of them."""

    strokes: Rows  # (n, 5)
    spread: Rows  # (n, 5) by which they may be wrong, as standard deviations
    success: Rows  # (n,) part of the last samples that succeeded
    miss: Rows  # (n,) mean miss of the better samples
    samples: NDArray[np.int64]  # (n,) how many samples that rests on

    def take(self, which: NDArray[np.int64]) -> 'Swarm':
        """Pick some of them."""
        fields: Any = (field[which] for field in self)
        return Swarm(*fields)


def swarm_of(guesses: Guesses, miss: Rows) -> Swarm:
    """Begin with guesses that were played."""
    strokes = guesses.strokes
    spread = np.empty_like(strokes)
    spread[:, :2], spread[:, ELEVATION] = OFFSETS, RAISE
    spread[:, AZIMUTH], spread[:, SPEED] = guesses.spread, FASTER * strokes[:, SPEED]
    success = (miss == 0.0).astype(float)
    return Swarm(strokes, spread, success, miss, np.ones(len(strokes), np.int64))


def improve(
    problem: Problem, runner: Runner, swarm: Swarm, draw: np.random.Generator, effort: float
) -> Iterator[Swarm]:
    """Go through all rounds, or as far as the budget goes; what is known after each."""
    for width, kept, samples in ROUNDS:
        count = max(4, round(effort * samples))
        if runner.left < len(swarm.strokes) * count:
            swarm = swarm.take(_order(swarm)[: max(1, runner.left // count)])
        if runner.left < count or not len(swarm.strokes):
            break
        swarm = _round(problem, runner, swarm, draw.standard_normal((count, 5)), width)
        swarm = swarm.take(_order(swarm)[: max(4, round(kept * len(swarm.strokes)))])
        runner.best = max(runner.best, float(swarm.success[0])) if width == 0.0 else runner.best
        yield swarm


def _order(swarm: Swarm) -> NDArray[np.int64]:
    order: NDArray[np.int64] = np.lexsort((swarm.miss, -swarm.success))
    return order


def _round(problem: Problem, runner: Runner, swarm: Swarm, normal: Rows, width: float) -> Swarm:
    """Sample around each stroke, with the same errors for all, and move it."""
    count, samples = len(swarm.strokes), len(normal)
    spread = np.hypot(problem.sigmas, width * swarm.spread)
    tried = swarm.strokes[:, np.newaxis] + spread[:, np.newaxis] * normal
    flat = tried.reshape(-1, 5)
    outcomes = runner.play(problem.limits.inside(flat) if width > 0.0 else flat)
    miss = outcomes.miss.reshape(count, samples)
    success = outcomes.success.reshape(count, samples)
    moved = np.empty_like(swarm.strokes)
    nearest = np.argsort(miss, axis=1, kind='stable')[:, : max(2, round(ELITE * samples))]
    for i in range(count):
        better = np.flatnonzero(success[i])
        if len(better) < nearest.shape[1]:
            better = nearest[i]
        moved[i] = tried[i, better].mean(axis=0)
    best = np.take_along_axis(miss, nearest, axis=1).mean(axis=1)
    strokes = raised(problem.scene, problem.limits, problem.limits.inside(moved))
    blocked = np.isnan(strokes).any(axis=1)
    strokes[blocked] = swarm.strokes[blocked]
    return Swarm(
        strokes, swarm.spread, success.mean(axis=1), best, np.full(count, samples, np.int64)
    )
