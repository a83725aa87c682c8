"""The search: guesses, the surest of them improved, and the best ones compared under noise."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import chain
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.chance import errors, wilson
from billiard_shot.planning.curves import curved_guesses, library
from billiard_shot.planning.guesses import (
    fanned,
    Guesses,
    guesses_along,
    joined,
    random_guesses,
    Way,
    ways_to,
)
from billiard_shot.planning.limits import AZIMUTH
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.runner import Runner, StoppedError
from billiard_shot.planning.strikes import Rows
from billiard_shot.planning.swarm import improve, Swarm, swarm_of
from billiard_shot.planning.waypoints import Waypoint, waypoints

NORMAL_BUDGET = 20_000  # simulations for which the numbers here are made
GUESSED = 0.3  # part of the budget for the guesses of a stage
WAYS = 24  # of each kind that are tried
CURVED, CURVED_POINTS = 360, 6  # curved guesses in all, and the waypoints that they are for
IMPROVED = 36
RACERS, FINALISTS = 8, 4  # strokes that race, and that are judged in the end
RACE, RACES = 128, 6  # strokes of each in a race, and races
AS_GOOD_AS_IT_GETS = 0.98
FRESH, FRESH_OTHERS = 800, 200  # strokes by which the winner is judged, and the others
SURE, POOR = 0.5, 0.1  # chances from which on no ways by one, or more, cushions are tried


cost_of = attrgetter('cost')

# Strokes are alike that differ by less than so many standard deviations, and than this, in all of
# a, b (ball radii), elevation, azimuth (rad) and speed (m/s).
ALIKE = 4.0
LIKE = np.array([0.15, 0.15, 0.05, 0.01, 0.3])


class Finalist(NamedTuple):
    """A stroke, and how often it succeeded in strokes that had no part in its choice."""

    stroke: Rows
    successes: int
    trials: int


def search(problem: Problem, runner: Runner, seed: int) -> tuple[list[Finalist], float, bool]:
    """
    Search until the budget is spent, the best is clear, or someone cancels.

    Returns
    -------
    finalists : list of Finalist
        The best first. Where there was no time to judge them, with what is known.
    miss : float
        How near the nearest stroke came, see `Outcomes`.
    cancelled : bool

    """
    draws = np.random.default_rng(seed)
    effort = min(1.0, max(0.25, runner.budget / NORMAL_BUDGET))
    found: list[Swarm] = []
    nearest = np.inf
    try:
        for stage in _stages(problem, runner):
            guesses = stage()
            guesses = guesses.take(np.arange(len(guesses.way))[: runner.left])
            if not len(guesses.way):
                continue
            miss = runner.play(guesses.strokes).miss
            nearest = min(nearest, float(miss.min()))
            chosen = _choice(guesses, miss, max(4, round(effort * IMPROVED)), draws)
            found.append(swarm_of(guesses.take(chosen), miss[chosen]))
            for better in improve(problem, runner, found[-1], draws, effort):
                found[-1] = better
            if runner.left <= 0:
                break
        runner.reserved = 0
        return _judged(problem, runner, _best(found), draws, effort), nearest, False
    except StoppedError:
        best = _best(found)
        best = best.take(_different(problem, best.strokes)[:FINALISTS])
        known = zip(best.strokes, best.success, best.samples.tolist(), strict=True)
        return [Finalist(stroke, round(part * n), n) for stroke, part, n in known], nearest, True


def _stages(problem: Problem, runner: Runner) -> Iterator[Callable[[], Guesses]]:
    """Kinds of guesses, the usual ones first."""
    room = max(1, round(GUESSED * min(runner.budget, NORMAL_BUDGET)))

    def usual() -> Guesses:
        points = waypoints(problem, 0)
        ways = [ways_to(problem, point, 0) for point in points]
        blocked = [point for point, found in zip(points, ways, strict=True) if not found]
        direct = sorted(chain.from_iterable(ways), key=cost_of)[:WAYS]
        parts = [fanned(guesses_along(problem, direct))]
        return _within(joined([*parts, *_bent(problem, runner, blocked)]), room)

    def cushions() -> Guesses:
        return _within(_round_about(problem, runner, ((0, 1), (1, 0)), WAYS), room)

    def more() -> Guesses:
        return _within(_round_about(problem, runner, ((0, 2), (2, 1)), 2 * WAYS), room)

    yield usual
    if problem.scene.table is not None:
        if runner.best < SURE:
            yield cushions
        if runner.best < POOR:
            yield more
    tried = 0
    while runner.left > 0 and runner.best < POOR:
        yield partial(random_guesses, problem, room, tried)
        tried += room


def _round_about(
    problem: Problem, runner: Runner, cushions: Sequence[tuple[int, int]], count: int
) -> Guesses:
    """Ways with up to so many cushions after and before the meeting of balls, `count` of each."""
    chosen: list[Way] = []
    for after, before in cushions:
        ways: list[Way] = []
        for point in waypoints(problem, after):
            runner.look()
            ways += ways_to(problem, point, before)
        chosen += sorted(ways, key=cost_of)[:count]
    return fanned(guesses_along(problem, chosen))


def _bent(problem: Problem, runner: Runner, points: list[Waypoint]) -> list[Guesses]:
    points = sorted(points, key=lambda point: point.after)[:CURVED_POINTS]
    if not points:
        return []
    strikes, found = library(problem), []
    for point in points:
        runner.look()
        found.append(fanned(curved_guesses(problem, strikes, point, CURVED // len(points))))
    return found


def _within(guesses: Guesses, room: int) -> Guesses:
    """Thin out to as many as there is room for, evenly."""
    if len(guesses.way) <= room:
        return guesses
    return guesses.take(np.linspace(0, len(guesses.way) - 1, room).astype(np.int64))


def _choice(
    guesses: Guesses, miss: Rows, count: int, draws: np.random.Generator
) -> NDArray[np.int64]:
    """
    Choose those that succeed, else the nearest ones, in turn from all ways.

    Of ways, those come first of which more guesses succeed.
    """
    hits = np.bincount(guesses.way, miss == 0.0)[guesses.way]
    order = np.lexsort((draws.permutation(len(miss)), miss, guesses.way))
    way = guesses.way[order]
    turn = np.empty(len(miss))  # of each guess, among those of its way
    turn[order] = np.arange(len(miss)) - np.searchsorted(way, way)
    chosen: NDArray[np.int64] = np.lexsort((miss, -hits, turn, miss > 0.0))[:count]
    return chosen


def _best(found: list[Swarm]) -> Swarm:
    """Join what the stages found, the most surely successful first."""
    if not found:
        nothing = np.empty((0, 5)), np.empty((0, 5)), np.empty(0), np.empty(0)
        return Swarm(*nothing, np.empty(0, np.int64))
    swarm = Swarm(*(np.concatenate(parts) for parts in zip(*found, strict=True)))
    known = zip(swarm.success.tolist(), swarm.samples.tolist(), strict=True)
    surely = np.array([wilson(part * n, n)[0] for part, n in known])
    return swarm.take(np.lexsort((swarm.miss, -surely)))


def _judged(
    problem: Problem, runner: Runner, swarm: Swarm, draws: np.random.Generator, effort: float
) -> list[Finalist]:
    """Let the best race each other, then judge them by strokes that had no part in the choice."""
    strokes = swarm.strokes[swarm.success > 0.0]
    strokes = strokes[_different(problem, strokes)[:RACERS]]
    judging = min(round(effort * (FRESH + (FINALISTS - 1) * FRESH_OTHERS)), runner.left // 2)
    runner.reserved = judging
    wins, trials = np.zeros(len(strokes)), 0
    for _ in range(RACES):
        race = min(round(effort * RACE), runner.left // max(1, len(strokes)))
        if len(strokes) < 2 or race < 8:
            break
        wins += _tries(problem, runner, strokes, errors(problem, draws, race))
        trials += race
        order = np.argsort(-wins, kind='stable')
        strokes, wins = strokes[order], wins[order]
        racing = _racing(wins, trials)
        if racing == 1:
            break
        if racing >= FINALISTS:
            strokes, wins = strokes[:racing], wins[:racing]
    runner.reserved = 0
    found = []
    for place, stroke in enumerate(strokes[:FINALISTS]):
        count = min(round(effort * (FRESH_OTHERS if place else FRESH)), runner.left)
        if count:
            noise = errors(problem, draws, count)
            found.append(
                Finalist(stroke, int(_tries(problem, runner, stroke[np.newaxis], noise)[0]), count)
            )
    return found[:1] + sorted(found[1:], key=lambda each: -each.successes / each.trials)


def _racing(wins: Rows, trials: int) -> int:
    """How many, of those with the most wins first, may still be the best; one that is sure."""
    low, _ = wilson(wins[0], trials)
    if low > AS_GOOD_AS_IT_GETS:
        return 1
    return sum(wilson(each, trials)[1] >= low for each in wins.tolist())


def _different(problem: Problem, strokes: Rows) -> NDArray[np.int64]:
    """Find the strokes (n, 5) that are no mere variations of earlier ones."""
    apart = np.maximum(ALIKE * problem.sigmas, LIKE)
    chosen: list[int] = []
    for i in range(len(strokes)):
        away = strokes[i] - strokes[chosen]
        away[:, AZIMUTH] = np.remainder(away[:, AZIMUTH] + np.pi, 2.0 * np.pi) - np.pi
        if not (np.abs(away) < apart).all(axis=1).any():
            chosen.append(i)
    return np.array(chosen, np.int64)


def _tries(problem: Problem, runner: Runner, strokes: Rows, noise: Rows) -> Rows:
    """How often each stroke succeeds under the same errors."""
    tried = (strokes[:, np.newaxis] + noise).reshape(-1, 5)
    success = runner.play(tried).success.reshape(len(strokes), len(noise))
    return success.sum(axis=1).astype(float)
