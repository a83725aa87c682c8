"""
Stages of a search: kinds of candidates, from straight paths to random strokes.

A kind is tried only if the kinds before it gave no stroke that is good enough.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
import math
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.curved_paths import curved_candidates
from billiard_shot.planning.evaluate import Outcomes
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.routes import (
    Candidates,
    candidates_along,
    random_candidates,
    Route,
    routes_to,
    spread_azimuth,
)
from billiard_shot.planning.runner import Runner
from billiard_shot.planning.waypoints import combinations, Waypoint, waypoints

CANDIDATES, CANDIDATE_SHARE = 6_000, 0.3  # of a stage: at most; and as a share of the budget
MAX_ROUTES = 24  # of each kind of route
CURVED_POINTS, CURVE_SHARE = 6, 0.13  # waypoints; curves that are simulated, of the budget
GOOD = 0.9  # value of a stroke with which only straight paths are tried
RANDOM_BELOW = 0.1  # value of a stroke: with a better one no random strokes are tried


@dataclass(slots=True)
class Stage:
    """Candidates of one kind, simulated without errors."""

    name: str
    candidates: Candidates
    outcomes: Outcomes
    width: float  # of the search around them, see `Kind`
    chosen: NDArray[np.bool_]  # (n,) candidates that were refined
    value: float = 0.0  # of its best stroke so far


def next_stage(
    problem: Problem,
    runner: Runner,
    stages: list[Stage],
    best: float,
    share: float = CANDIDATE_SHARE,
) -> Stage | None:
    """
    Simulate the candidates of the next kind that has any.

    Parameters
    ----------
    problem : Problem
    runner : Runner
    stages : list of Stage
        The stages so far; those of all kinds that are tried now are added, also empty ones.
    best : float
        Value of the best stroke so far.
    share : float
        Share of the budget that a stage may have.

    Returns
    -------
    Stage or None
        None if the best stroke is good enough, or the budget is spent.

    """
    while runner.left > 0 or not stages:
        name, below, make, width = _kind(len(stages))
        if best >= below:
            break
        made = make(problem, runner)
        most = min(CANDIDATES, max(1, round(share * runner.budget)), runner.left)
        evenly = np.linspace(0, len(made.route) - 1, min(len(made.route), most))
        made = made.take(evenly.astype(np.int64))
        outcomes = runner.evaluate(made.strokes)
        count = len(outcomes.penalty)  # fewer than there are candidates, if the time is up
        chosen = np.zeros(count, np.bool_)
        stages.append(Stage(name, made.take(np.arange(count)), outcomes, width, chosen))
        if count:
            return stages[-1]
    return None


def untried(stages: list[Stage], best: float) -> tuple[str, ...]:
    """Name the kinds of candidates that are called for with a best value, but were not tried."""
    return tuple(kind.name for kind in KINDS[len(stages) :] if best < kind.below)


class Kind(NamedTuple):
    """A kind of candidates."""

    name: str
    below: float  # it is tried if no stroke so far has a value as good as this
    make: Callable[[Problem, Runner], Candidates]
    # Of the search around candidates in offsets and speed: smaller if these are nearly right.
    width: float = 1.0


def _kind(number: int) -> Kind:
    """Return one of `KINDS`; after those, further random strokes."""
    if number < len(KINDS):
        return KINDS[number]
    return Kind('random strokes', RANDOM_BELOW, partial(_random, number - len(KINDS)))


def _along(problem: Problem, points: Iterable[Waypoint]) -> Candidates:
    """Make candidates along the best direct routes to waypoints."""
    routes = chain.from_iterable(routes_to(problem, point, 0) for point in points)
    return spread_azimuth(candidates_along(problem, _cheapest(routes, MAX_ROUTES)))


def _cheapest(routes: Iterable[Route], count: int) -> list[Route]:
    return sorted(routes, key=attrgetter('cost'))[:count]


def _straight(problem: Problem, _: Runner) -> Candidates:
    return _along(problem, waypoints(problem, 0))


def _combinations(problem: Problem, _: Runner) -> Candidates:
    return _along(problem, combinations(problem))


def _by_cushions(
    pairs: Sequence[tuple[int, int]], count: int, problem: Problem, runner: Runner
) -> Candidates:
    """Make candidates along the `count` best routes for each pair of cushions, (after, before)."""
    chosen: list[Route] = []
    for after, before in pairs if problem.scene.table else ():
        routes: list[Route] = []
        for point in waypoints(problem, after):
            runner.poll()
            routes += routes_to(problem, point, before)
        chosen += _cheapest(routes, count)
    return spread_azimuth(candidates_along(problem, chosen))


def _curved(problem: Problem, runner: Runner) -> Candidates:
    """Make candidates along curved paths to waypoints without a straight route."""
    points = [at for at in waypoints(problem, 0) if not routes_to(problem, at, 0)]
    points = sorted(points, key=attrgetter('after'))[:CURVED_POINTS]
    if not points:
        return candidates_along(problem, [])
    most = round(CURVE_SHARE * runner.budget)
    return spread_azimuth(curved_candidates(problem, points, most, runner))


def _random(before: int, problem: Problem, _: Runner) -> Candidates:
    """Make random candidates, after others were made `before` times."""
    return random_candidates(problem, CANDIDATES, before * CANDIDATES)


KINDS = (
    Kind('straight paths', math.inf, _straight),
    Kind('combinations', GOOD, _combinations),
    Kind('one cushion', 0.5, partial(_by_cushions, ((0, 1), (1, 0)), MAX_ROUTES)),
    Kind('curves', 0.3, _curved, width=0.5),  # late, because a curve takes long
    Kind('two cushions', RANDOM_BELOW, partial(_by_cushions, ((0, 2), (2, 1)), 2 * MAX_ROUTES)),
)
