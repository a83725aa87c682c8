"""
Paths past balls that block the direct route: curves and massés around them, jumps over them.

The path of a ball on a cloth scales with the square of the cue speed: at twice the speed it has
the same shape and is four times as large. One path for each pair of offsets and each elevation
therefore serves all speeds and directions: the path at 1 m/s along +x is scaled and turned so that
it goes through the waypoint.
"""

from collections.abc import Callable
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import raise_for_clearance
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.routes import Candidates, spread_of
from billiard_shot.planning.waypoints import distances_from, MIN_CUT_COSINE, Waypoint
from billiard_shot.records import Array
from billiard_shot.scene.player import AZIMUTH, ELEVATION
from billiard_shot.shot.accuracy import Accuracy
from billiard_shot.shot.play import play_by
from billiard_shot.shot.setting import alone
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.status import Status
from billiard_shot.table.task import run_recorded
from billiard_shot.table.trajectory import Trajectory

SIDE_FACTORS = (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9)  # a and b relative to the largest offset
HEIGHT_FACTORS = (-0.8, -0.4, 0.0, 0.4, 0.8)
CURVE_ELEVATIONS = tuple(
    math.radians(degrees) for degrees in (4, 9, 15, 22, 30, 38, 46, 54, 62, 70, 78)
)
SPEED_COUNT_OF_CURVES = 14
# A path is approximated by lines: number for each of its first segments, number of these segments,
# and number for all other segments together.
LINES_PER_SEGMENT, DENSE_SEGMENTS, COARSE_LINES = 6, 6, 12
MAX_SEGMENTS = 40  # of a path
CURVE_TOLERANCE = 1e-4  # m, of a path at 1 m/s
PATH_POINTS = LINES_PER_SEGMENT * DENSE_SEGMENTS + COARSE_LINES + 1  # points of a path
MIN_CLEARANCE = 0.003  # m, of a path from other balls
MAX_ARRIVAL_HEIGHT = 0.8  # ball radii above the cloth: a higher ball does not hit another one well


class StrikeLibrary(NamedTuple):
    """Strikes of a cue at 1 m/s along +x, and the paths of the ball on an endless cloth."""

    offsets: Array  # (n, 3) a, b and elevation
    paths: Array  # (n, PATH_POINTS, 3) m relative to the start; z is 0 on the cloth


def build_strike_library(problem: Problem) -> StrikeLibrary:
    """Simulate strikes on a grid of offsets and elevations within the limits."""
    robot = problem.limits.robot
    low, high = problem.limits.elevations
    offsets = np.array(
        [
            (robot.offset_max * side, robot.offset_max * height, elevation)
            for elevation in CURVE_ELEVATIONS
            if low <= elevation <= high
            for height in HEIGHT_FACTORS
            for side in SIDE_FACTORS
            if math.hypot(side, height) <= 1.0
        ]
    ).reshape(-1, 3)
    strokes = np.column_stack([offsets, np.zeros(len(offsets)), np.ones(len(offsets))])
    model = problem.model._replace(follow_through=0.0)  # double hits do not scale with the speed
    accuracy = Accuracy(CURVE_TOLERANCE, checked=False)
    run = play_by(run_recorded, alone(model), *vectors_of(strokes), None, accuracy)
    ends = run.tables['segments']
    usual = (run.status == Status.OK) & ~run.cues['miscue']
    kept = np.flatnonzero(usual & (np.diff(ends, prepend=0) <= MAX_SEGMENTS))
    motions = np.split(run.segments, ends[:-1])
    paths = [Trajectory(motions[i].copy()) for i in kept]
    start = np.array([0.0, 0.0, problem.radius])
    places = [path.at(_times(path)).position - start for path in paths]
    return StrikeLibrary(offsets[kept], np.array(places).reshape(-1, PATH_POINTS, 3))


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


def curved_candidates(
    problem: Problem,
    strikes: StrikeLibrary,
    point: Waypoint,
    count: int,
    goes_on: Callable[[], bool],
) -> Candidates:
    """Find up to `count` strokes whose paths reach a waypoint clear of all other balls."""
    robot = problem.limits.robot
    slowest = min(max(0.6, robot.speed_min), robot.speed_max)
    found, spreads = [np.empty((0, 5))], [np.empty(0)]
    for speed in np.geomspace(slowest, robot.speed_max, SPEED_COUNT_OF_CURVES):
        if not goes_on():
            break
        paths = strikes.paths * speed**2
        azimuth, clear, cut, length = _turn_through(problem, paths, point)
        fit = np.flatnonzero(clear & (cut > MIN_CUT_COSINE))
        found.append(
            np.column_stack([strikes.offsets[fit], azimuth[fit], np.full(len(fit), speed)])
        )
        spreads.append(np.array([spread_of(problem, point, length, float(cut[i])) for i in fit]))
    strokes, spread = np.concatenate(found), np.concatenate(spreads)
    allowed = problem.limits.allows_azimuth(strokes[:, AZIMUTH])
    strokes, spread = strokes[allowed], spread[allowed]
    raised = raise_for_clearance(problem.scene, problem.limits, strokes)
    # A higher cue gives another path.
    free = np.flatnonzero(np.abs(raised[:, ELEVATION] - strokes[:, ELEVATION]) < 1e-9)
    # chosen evenly from all speeds and elevations
    free = free[np.linspace(0, len(free) - 1, min(count, len(free))).astype(np.int64)]
    return Candidates(raised[free], spread[free], np.zeros(len(free), np.int64))


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
            clear[rows] = apart > 2.0 * problem.radius + MIN_CLEARANCE
    step = p1 - p0
    heading = np.stack(
        [cosine * step[:, 0] - sine * step[:, 1], sine * step[:, 0] + cosine * step[:, 1]], axis=1
    )
    size = np.maximum(np.hypot(*heading.T), 1e-12)
    cut = heading @ point.push / size if point.struck else np.ones(len(paths))
    return azimuth, clear, cut, distance
