"""The search: guesses, the surest of them improved, and the best ones compared under noise."""
from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.chance import errors, wilson
from billiard_shot.planning.curves import curved_guesses
from billiard_shot.planning.guesses import (
    fanned,
    Guesses,
    guesses_along,
    joined,
    random_guesses,
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
CURVED = 60  # curved guesses for each waypoint
CURVED_POINTS = 6
PER_WAY = 3  # guesses of a way that are improved
IMPROVED = 24
FINALISTS = 4
RACE, RACES = 128, 4  # strokes of each finalist in a race, and races
FRESH = 600  # strokes of each finalist by which it is judged in the end
SURE, POOR = 0.5, 0.1  # chances from which on no ways by one, or more, cushions are tried


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
            found[-1] = improve(problem, runner, found[-1], draws, effort)
            if runner.left <= 0:
                break
        runner.reserved = 0
        return _judged(problem, runner, _best(found), draws, effort), nearest, False
    except StoppedError:
        best = _best(found)
        known = zip(best.strokes, best.success, strict=True)
        return [Finalist(stroke, round(64 * part), 64) for stroke, part in known], nearest, True


def _stages(problem: Problem, runner: Runner) -> Iterator[Callable[[], Guesses]]:
    """Kinds of guesses, the usual ones first."""
    room = max(1, round(GUESSED * runner.budget))

    def usual() -> Guesses:
        points = waypoints(problem, 0)
        direct = ways_to(problem, points, 0)[:WAYS]
        parts = [fanned(guesses_along(problem, direct))]
        blocked = [point for point in points if not ways_to(problem, [point], 0)]
        parts.append(_bent(problem, blocked))
        return _within(joined(parts), room)

    def cushions() -> Guesses:
        kicks = ways_to(problem, waypoints(problem, 0), 1)[:WAYS]
        banks = ways_to(problem, waypoints(problem, 1), 0)[:WAYS]
        return _within(fanned(guesses_along(problem, kicks + banks)), room)

    def more() -> Guesses:
        kicks = ways_to(problem, waypoints(problem, 0), 2)[: 2 * WAYS]
        banks = ways_to(problem, waypoints(problem, 2), 1)[: 2 * WAYS]
        return _within(fanned(guesses_along(problem, kicks + banks)), room)

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


def _bent(problem: Problem, points: list[Waypoint]) -> Guesses:
    points = sorted(points, key=lambda point: point.after)[:CURVED_POINTS]
    return fanned(curved_guesses(problem, points, CURVED))


def _within(guesses: Guesses, room: int) -> Guesses:
    """Thin out to as many as there is room for, evenly."""
    if len(guesses.way) <= room:
        return guesses
    return guesses.take(np.linspace(0, len(guesses.way) - 1, room).astype(np.int64))


def _choice(
    guesses: Guesses, miss: Rows, count: int, draws: np.random.Generator
) -> NDArray[np.int64]:
    """The nearest ones, but few of each way; of those that succeed, by how many of the way do."""
    ways = int(guesses.way.max()) + 1
    hits = np.bincount(guesses.way, miss == 0.0, ways)
    order = np.lexsort((draws.permutation(len(miss)), -hits[guesses.way], miss))
    chosen: list[int] = []
    taken = np.zeros(ways, np.int64)
    for i in order:
        if taken[guesses.way[i]] < PER_WAY:
            taken[guesses.way[i]] += 1
            chosen.append(int(i))
        if len(chosen) == count:
            break
    return np.array(chosen, np.int64)


def _best(found: list[Swarm]) -> Swarm:
    """Join what the stages found, the most successful first."""
    if not found:
        nothing = np.empty((0, 5)), np.empty((0, 5)), np.empty(0), np.empty(0)
        return Swarm(*nothing)
    swarm = Swarm(*(np.concatenate(parts) for parts in zip(*found, strict=True)))
    return swarm.take(np.lexsort((swarm.miss, -swarm.success)))


def _judged(
    problem: Problem, runner: Runner, swarm: Swarm, draws: np.random.Generator, effort: float
) -> list[Finalist]:
    """Let the best race each other, then judge them by strokes that had no part in the choice."""
    swarm = swarm.take(_different(problem, swarm.strokes)[:FINALISTS])
    strokes = swarm.strokes
    wins, trials = np.zeros(len(strokes)), 0
    fresh = max(16, min(round(effort * FRESH), runner.left // (2 * max(1, len(strokes)))))
    for _ in range(RACES):
        race = min(round(effort * RACE), runner.left // max(1, len(strokes)) - fresh)
        if len(strokes) < 2 or race < 8:
            break
        wins += _tries(problem, runner, strokes, errors(problem, draws, race))
        trials += race
        if _clear(wins, trials):
            break
    strokes = strokes[np.argsort(-wins, kind='stable')]
    count = min(fresh, runner.left // max(1, len(strokes)))
    if count < 1:
        return [Finalist(s, round(p * 64), 64) for s, p in
                zip(strokes, swarm.success, strict=True)]
    wins = _tries(problem, runner, strokes, errors(problem, draws, count))
    others = np.argsort(-wins[1:], kind='stable') + 1
    return [
        Finalist(strokes[i], int(wins[i]), count) for i in (0, *others)
    ] if len(strokes) else []


def _different(problem: Problem, strokes: Rows) -> NDArray[np.int64]:
    """Indices of strokes (n, 5) that are no mere variations of earlier ones."""
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


def _clear(wins: Rows, trials: int) -> bool:
    """Whether the leader is surely the best, or so good that it does not matter."""
    order = np.sort(wins)[::-1]
    low, _ = wilson(order[0], trials)
    return low > wilson(order[1], trials)[1] or low > 0.98
