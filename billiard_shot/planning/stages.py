"""Stages of a search: kinds of candidates, from straight and curved paths to random strokes."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
import math
from operator import attrgetter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.problem import Problem, raise_for_clearance
from billiard_shot.planning.routes import (
    Candidates,
    candidates_along,
    combinations,
    distances_from,
    MIN_CUT_COSINE,
    random_candidates,
    Route,
    routes_to,
    spread_azimuth,
    spread_of,
    strokes_within,
    Waypoint,
    waypoints,
)
from billiard_shot.planning.runner import Outcomes, Runner
from billiard_shot.planning.statistics import quasi_random
from billiard_shot.records import Array, ROWS
from billiard_shot.scene.player import AZIMUTH, ELEVATION
from billiard_shot.shot.effects import StrikeModel
from billiard_shot.shot.play import Accuracy, alone, task_of
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.status import OK
from billiard_shot.table.model.motion import BallRule
from billiard_shot.table.run.results import Trajectory
from billiard_shot.table.run.task import run_recorded

CURVES, CURVES_AT_ONCE = 8_000, 100  # simulated strokes at most; between two polls of the search
ENOUGH = 60  # candidates
CURVE_TIME = 0.4  # share of the time of a search in which its first candidates are found
SLOWEST = 0.6  # m/s, of the cue
# A path is approximated by lines: number for each of its first segments, number of these segments,
# and number for all other segments together.
LINES_PER_SEGMENT, DENSE_SEGMENTS, COARSE_LINES = 6, 6, 12
MAX_SEGMENTS = 40  # of a path
CURVE_TOLERANCE = 1e-3  # m, of a path
PATH_POINTS = LINES_PER_SEGMENT * DENSE_SEGMENTS + COARSE_LINES + 1  # points of a path
MAX_ARRIVAL_HEIGHT = 0.8  # ball radii above the cloth: a higher ball does not hit another one well


class Curves(NamedTuple):
    """Strokes along +x, and the paths of the ball on an endless cloth."""

    strokes: Array  # (n, 5) a, b, elevation, azimuth, speed
    paths: Array  # (n, PATH_POINTS, 3) m relative to the start; z is 0 on the cloth


def curved_candidates(
    problem: Problem, points: list[Waypoint], most: int, runner: Runner
) -> Candidates:
    """
    Find strokes whose paths reach waypoints clear of all other balls.

    At most `most` strokes are simulated, and no more if `ENOUGH` are found, or the search does not
    go on. If some are found, the others must not take more than `CURVE_TIME` of the time.
    """
    robot, count = problem.limits.robot, min(most, CURVES)
    slowest = min(max(SLOWEST, robot.speed_min), robot.speed_max)
    draws = quasi_random(count, 5)
    draws[:, ELEVATION] **= 1.5  # lower strokes repeat better, and are simulated faster
    strokes = strokes_within(problem.limits, draws, slowest)
    strokes[:, AZIMUTH] = 0.0
    found = [Candidates(np.empty((0, 5)), np.empty(0), np.empty(0, np.int64))]
    parts = [
        (problem.model, strokes[first : first + CURVES_AT_ONCE])
        for first in range(0, count, CURVES_AT_ONCE)
    ]
    for curves in runner.each(simulate_curves, parts):
        found += [_through(problem, curves, point, number) for number, point in enumerate(points)]
        count = sum(len(each.route) for each in found)
        if runner.left <= 0 or count >= ENOUGH or (count and runner.has_used(CURVE_TIME)):
            break
    return Candidates(*map(np.concatenate, zip(*found, strict=True)))


def simulate_curves(model: StrikeModel, strokes: Array) -> Curves:
    """Simulate strokes (n, 5) along +x, and keep those that do not fail, with their paths."""
    accuracy = Accuracy(CURVE_TOLERANCE, checked=False)
    rules = ROWS.records(BallRule, 1)  # a stroke that fails ends there
    task = task_of(alone(model), *vectors_of(strokes), None, accuracy, rules=rules)
    run = run_recorded(task)
    ends = run.tables['segments']
    usual = (run.tables['status'] == OK) & ~run.cues['miscue'] & ~run.tables['double_hit']
    kept = np.flatnonzero(usual & (np.diff(ends, prepend=0) <= MAX_SEGMENTS))
    motions = np.split(run.segments, ends[:-1])
    paths = [Trajectory(motions[i].copy()) for i in kept]
    start = np.array([0.0, 0.0, model.surface.radius])
    places = [path.at(_times(path)).position - start for path in paths]
    return Curves(strokes[kept], np.array(places).reshape(-1, PATH_POINTS, 3))


def _times(path: Trajectory) -> Array:
    """Choose times of PATH_POINTS points, densely on the short, curved first segments."""
    starts = path.rows['time'][: DENSE_SEGMENTS + 1]
    ends = np.append(starts, np.full(DENSE_SEGMENTS + 1 - len(starts), path.duration))
    dense = np.interp(
        np.arange(DENSE_SEGMENTS * LINES_PER_SEGMENT) / LINES_PER_SEGMENT,
        np.arange(DENSE_SEGMENTS + 1),
        ends,
    )
    return np.append(dense, np.linspace(ends[-1], path.duration, COARSE_LINES + 1))


def _through(problem: Problem, curves: Curves, point: Waypoint, number: int) -> Candidates:
    """Turn strokes to a waypoint with this number; return those that reach it past all balls."""
    azimuth, clear, cut, length = _turn_through(problem, curves.paths, point)
    fit = np.flatnonzero(clear & (cut > MIN_CUT_COSINE) & problem.limits.allows_azimuth(azimuth))
    strokes = curves.strokes[fit]
    strokes[:, AZIMUTH] = azimuth[fit]
    raised = raise_for_clearance(problem.scene, problem.limits, strokes)
    # A higher cue gives another path.
    free = np.flatnonzero(np.abs(raised[:, ELEVATION] - strokes[:, ELEVATION]) < 1e-9)
    spread = [spread_of(problem, point, length, each) for each in cut[fit[free]].tolist()]
    return Candidates(raised[free], np.array(spread), np.full(len(free), number))


def _turn_through(
    problem: Problem, paths: Array, point: Waypoint
) -> tuple[Array, NDArray[np.bool_], Array, float]:
    """
    Turn paths (n, PATH_POINTS, 3) so that they go through a waypoint.

    Returns azimuths (n,), whether the path reaches the waypoint clear of other balls and cushions
    (n,), cosines of the cut (n,), and the distance [m].
    """
    ahead = point.place - problem.cue_ball
    distance = float(np.hypot(*ahead))
    radii = np.hypot(paths[..., 0], paths[..., 1])
    beyond = radii >= distance
    index = np.where(beyond.any(axis=1), beyond.argmax(axis=1), 0)
    row = np.arange(len(paths))
    reaches = index > 0
    before = np.maximum(index - 1, 0)
    r0, r1 = radii[row, before], radii[row, index]
    part = np.where(reaches, (distance - r0) / np.where(r1 > r0, r1 - r0, 1.0), 0.0)
    p0, p1 = paths[row, before], paths[row, index]
    there = p0 + part[:, np.newaxis] * (p1 - p0)
    azimuth = math.atan2(ahead[1], ahead[0]) - np.arctan2(there[:, 1], there[:, 0])
    turn = np.exp(1j * azimuth)[:, np.newaxis]
    # the path up to the waypoint, in the frame of the table
    reached = np.arange(PATH_POINTS) <= before[:, np.newaxis]
    points = np.where(reached[..., np.newaxis], paths, there[:, np.newaxis])
    level = complex(*problem.cue_ball) + turn * (points[..., 0] + 1j * points[..., 1])
    world = np.stack([level.real, level.imag, points[..., 2]], axis=2)
    inside = (np.abs(world[..., :2]).max(axis=1) <= problem.half_sizes).all(axis=1)
    clear = reaches & (there[:, 2] < MAX_ARRIVAL_HEIGHT * problem.radius) & inside
    for other in range(1, len(problem.places)):
        if other != point.struck:
            rows = np.flatnonzero(clear)
            apart = distances_from(world[rows], np.array([*problem.places[other], 0.0]))
            clear[rows] = apart > 2.0 * problem.radius
    x, y, _ = (p1 - p0).T
    step = turn[:, 0] * (x + 1j * y)
    along = (step * complex(*point.push).conjugate()).real / np.maximum(np.abs(step), 1e-12)
    return azimuth, clear, along if point.struck else np.ones(len(paths)), distance


CANDIDATES, CANDIDATE_SHARE = 6_000, 0.3  # of a stage: at most; and as a share of the budget
MAX_ROUTES = 24  # of each kind of route
CURVED_POINTS, CURVE_SHARE = 6, 0.13  # waypoints; curves that are simulated, of the budget
GOOD = 0.9  # value of a stroke with which only straight paths are tried
RANDOM_BELOW = 0.1  # value of a stroke: with a better one no random strokes are tried


class CandidateKind(NamedTuple):
    """A kind of candidates."""

    name: str
    below: float  # it is tried if no stroke so far has a value as good as this
    make: Callable[[Problem, Runner], Candidates]
    # Of the search around candidates in offsets and speed: smaller if these are nearly right.
    width: float = 1.0
    refined: int = 80  # candidates that are refined in each round


@dataclass(slots=True)
class Stage:
    """Candidates of one kind, simulated without errors."""

    kind: CandidateKind
    candidates: Candidates
    outcomes: Outcomes
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
        kind = _kind(len(stages))
        if best >= kind.below:
            break
        made = kind.make(problem, runner)
        most = min(CANDIDATES, max(1, round(share * runner.budget)), runner.left)
        evenly = np.linspace(0, len(made.route) - 1, min(len(made.route), most))
        made = made.take(evenly.astype(np.int64))
        outcomes = runner.evaluate(made.strokes)
        count = len(outcomes.penalty)  # fewer than there are candidates, if the time is up
        chosen = np.zeros(count, np.bool_)
        stages.append(Stage(kind, made.take(np.arange(count)), outcomes, chosen))
        if count:
            return stages[-1]
    return None


def untried(stages: list[Stage], best: float) -> tuple[str, ...]:
    """Name the kinds of candidates that are called for with a best value, but were not tried."""
    return tuple(kind.name for kind in KINDS[len(stages) :] if best < kind.below)


def _kind(number: int) -> CandidateKind:
    """Return one of `KINDS`; after those, further random strokes."""
    if number < len(KINDS):
        return KINDS[number]
    return CandidateKind('random strokes', RANDOM_BELOW, partial(_random, number - len(KINDS)))


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
    CandidateKind('straight paths', math.inf, _straight),
    CandidateKind('combinations', GOOD, _combinations),
    CandidateKind('one cushion', 0.5, partial(_by_cushions, ((0, 1), (1, 0)), MAX_ROUTES)),
    # late, and few are refined, because a curve takes long
    CandidateKind('curves', 0.3, _curved, width=0.5, refined=40),
    CandidateKind(
        'two cushions', RANDOM_BELOW, partial(_by_cushions, ((0, 2), (2, 1)), 2 * MAX_ROUTES)
    ),
)
