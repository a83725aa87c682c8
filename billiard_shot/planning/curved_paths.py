"""
Paths past balls that block the direct route: curves and massés around them, jumps over them.

Strokes of all offsets, elevations and speeds are simulated once, along +x on an endless cloth. The
paths of the ball are then turned so that they go through a waypoint.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import raise_for_clearance
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.routes import Candidates, spread_of, strokes_within
from billiard_shot.planning.runner import Runner
from billiard_shot.planning.statistics import quasi_random
from billiard_shot.planning.waypoints import distances_from, MIN_CUT_COSINE, Waypoint
from billiard_shot.records import Array, ROWS
from billiard_shot.scene.player import AZIMUTH, ELEVATION
from billiard_shot.shot.accuracy import Accuracy
from billiard_shot.shot.play import play_by
from billiard_shot.shot.setting import alone
from billiard_shot.shot.strike_model import StrikeModel
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.status import Status
from billiard_shot.table.simulation_state import BallRule
from billiard_shot.table.task import run_recorded
from billiard_shot.table.trajectory import Trajectory

CURVES, CURVES_AT_ONCE = 8_000, 100  # simulated strokes at most; between two polls of the search
ENOUGH = 60  # candidates
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
    go on.
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
        if runner.left <= 0 or sum(len(each.route) for each in found) >= ENOUGH:
            break
    return Candidates(*map(np.concatenate, zip(*found, strict=True)))


def simulate_curves(model: StrikeModel, strokes: Array) -> Curves:
    """Simulate strokes (n, 5) along +x, and keep those that do not fail, with their paths."""
    accuracy = Accuracy(CURVE_TOLERANCE, checked=False)
    rules = ROWS.records(BallRule, 1)  # a stroke that fails ends there
    run = play_by(run_recorded, alone(model), *vectors_of(strokes), None, accuracy, rules=rules)
    ends = run.tables['segments']
    usual = (run.status == Status.OK) & ~run.cues['miscue'] & ~run.tables['double_hit']
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
    sine, cosine = np.sin(azimuth), np.cos(azimuth)
    # the path up to the waypoint, in the frame of the table
    reached = np.arange(PATH_POINTS) <= before[:, np.newaxis]
    points = np.where(reached[..., np.newaxis], paths, there[:, np.newaxis])
    x = problem.cue_ball[0] + cosine[:, None] * points[..., 0] - sine[:, None] * points[..., 1]
    y = problem.cue_ball[1] + sine[:, None] * points[..., 0] + cosine[:, None] * points[..., 1]
    world = np.stack([x, y, points[..., 2]], axis=2)
    half_length, half_width = problem.half_sizes
    inside = (np.abs(x).max(axis=1) <= half_length) & (np.abs(y).max(axis=1) <= half_width)
    clear = reaches & (there[:, 2] < MAX_ARRIVAL_HEIGHT * problem.radius) & inside
    for other in range(1, len(problem.places)):
        if other != point.struck:
            rows = np.flatnonzero(clear)
            apart = distances_from(world[rows], np.array([*problem.places[other], 0.0]))
            clear[rows] = apart > 2.0 * problem.radius
    step = p1 - p0
    heading = np.stack(
        [cosine * step[:, 0] - sine * step[:, 1], sine * step[:, 0] + cosine * step[:, 1]], axis=1
    )
    size = np.maximum(np.hypot(*heading.T), 1e-12)
    cut = heading @ point.push / size if point.struck else np.ones(len(paths))
    return azimuth, clear, cut, distance
