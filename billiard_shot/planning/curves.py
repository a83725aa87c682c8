"""
Curved ways past what stands in a straight one: curve and massé around it, jumps over it.

Nothing in the motion of a ball on a cloth has a length of its own but gravity's: of a cue that
comes twice as fast, the ball takes the same path four times as large. So one path for each pair of
offsets and elevation serves for all speeds and directions: that of 1 m/s along +x is enlarged so
far, and turned so, that it goes through the waypoint.
"""

import math
from typing import NamedTuple

import numpy as np

from billiard_shot.planning.guesses import Guesses, spread_of
from billiard_shot.planning.limits import raised
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.strikes import Rows, vectors_of
from billiard_shot.planning.waypoints import THINNEST, Waypoint
from billiard_shot.shot.strike import strike_batch
from billiard_shot.status import Status
from billiard_shot.table.trajectory import Trajectory

SIDES = (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9)  # a and b, parts of the largest offset
HEIGHTS = (-0.8, -0.4, 0.0, 0.4, 0.8)
ELEVATIONS = tuple(math.radians(degrees) for degrees in (4, 9, 15, 22, 30, 38, 46, 54, 62, 70, 78))
SPEEDS = 14
PIECES, STRETCHES, REST = 6, 6, 12  # lines for each of so many stretches of a path, and the rest
MOST = 40  # segments of a path
SAMPLES = PIECES * STRETCHES + REST + 1  # points of a path
ROOM = 0.003  # m that a path should keep from balls
LOW = 0.8  # radii above the cloth up to which a ball that arrives can still hit one well


class Library(NamedTuple):
    """Strikes of a cue at 1 m/s along +x, and the ways of the ball on an endless cloth."""

    kinds: Rows  # (n, 3) offsets and elevations
    paths: Rows  # (n, SAMPLES, 3) m from where the ball lay: on the cloth, its height is 0


def library(problem: Problem) -> Library:
    """Play strikes of all kinds within the limits."""
    robot = problem.limits.robot
    low, high = problem.limits.elevations
    kinds = np.array(
        [
            (robot.offset_max * side, robot.offset_max * height, elevation)
            for elevation in ELEVATIONS
            if low <= elevation <= high
            for height in HEIGHTS
            for side in SIDES
            if math.hypot(side, height) <= 1.0
        ]
    ).reshape(-1, 3)
    strokes = np.column_stack([kinds, np.zeros(len(kinds)), np.ones(len(kinds))])
    normals, velocities = vectors_of(strokes)
    centre = np.array([0.0, 0.0, problem.radius])
    paths, kept = [], []
    for i in range(len(kinds)):
        played = strike_batch(
            problem.model, normals[i : i + 1], velocities[i : i + 1], centre, 1e-4, segments=MOST
        )
        if played.strikes['status'][0] == Status.OK and len(played.segments) <= MOST:
            path = Trajectory(played.segments)
            paths.append(path.at(_times(path)).position - centre)
            kept.append(i)
    return Library(kinds[kept], np.array(paths).reshape(-1, SAMPLES, 3))


def _times(path: Trajectory) -> Rows:
    """Choose times of SAMPLES points: the first stretches, short and curved, densely."""
    begins = path.rows['time'][: STRETCHES + 1]
    ends = np.append(begins, np.full(STRETCHES + 1 - len(begins), path.duration))
    dense = np.interp(np.arange(STRETCHES * PIECES) / PIECES, np.arange(STRETCHES + 1), ends)
    return np.append(dense, np.linspace(ends[-1], path.duration, REST + 1))


def curved_guesses(problem: Problem, strikes: Library, point: Waypoint, count: int) -> Guesses:
    """Up to so many strokes whose paths lead to a waypoint past all other balls."""
    robot = problem.limits.robot
    slowest = min(max(0.6, robot.speed_min), robot.speed_max)
    found, spreads = [], []
    for speed in np.geomspace(slowest, robot.speed_max, SPEEDS):
        paths = strikes.paths * speed**2
        azimuth, gap, cut, length = _through(problem, paths, point)
        fit = np.flatnonzero((gap > 0.0) & (cut > THINNEST))
        found.append(np.column_stack([strikes.kinds[fit], azimuth[fit], np.full(len(fit), speed)]))
        spreads.append(np.array([spread_of(problem, point, length, float(cut[i])) for i in fit]))
    strokes, spread = np.concatenate(found), np.concatenate(spreads)
    allowed = problem.limits.allows(strokes[:, 3])
    strokes, spread = strokes[allowed], spread[allowed]
    lifted = raised(problem.scene, problem.limits, strokes)
    free = np.flatnonzero(np.abs(lifted[:, 2] - strokes[:, 2]) < 1e-9)  # others: another path
    # an even choice of all speeds and elevations
    free = free[np.linspace(0, len(free) - 1, min(count, len(free))).astype(np.int64)]
    return Guesses(lifted[free], spread[free], np.zeros(len(free), np.int64))


def _through(problem: Problem, paths: Rows, point: Waypoint) -> tuple[Rows, Rows, Rows, float]:
    """
    Turn paths (n, SAMPLES, 3) so that they go through a waypoint.

    Returns azimuths (n,), the room they keep from other balls and cushions (n,) [m] (negative:
    too little, or they do not get there), cosines of the cut (n,), and the distance.
    """
    ahead = point.place - problem.cue_ball
    distance = float(np.hypot(*ahead))
    radii = np.hypot(paths[..., 0], paths[..., 1])
    beyond = radii >= distance
    index = np.where(beyond.any(axis=1), beyond.argmax(axis=1), 0)
    row = np.arange(len(paths))
    gets_there = index > 0
    before = np.maximum(index - 1, 0)
    r0, r1 = radii[row, before], radii[row, index]
    part = np.where(gets_there, (distance - r0) / np.where(r1 > r0, r1 - r0, 1.0), 0.0)
    p0, p1 = paths[row, before], paths[row, index]
    there = p0 + part[:, np.newaxis] * (p1 - p0)
    turn = math.atan2(ahead[1], ahead[0]) - np.arctan2(there[:, 1], there[:, 0])
    sine, cosine = np.sin(turn), np.cos(turn)
    # the path up to the waypoint, in the frame of the table
    reached = np.arange(SAMPLES) <= before[:, np.newaxis]
    points = np.where(reached[..., np.newaxis], paths, there[:, np.newaxis])
    x = problem.cue_ball[0] + cosine[:, None] * points[..., 0] - sine[:, None] * points[..., 1]
    y = problem.cue_ball[1] + sine[:, None] * points[..., 0] + cosine[:, None] * points[..., 1]
    world = np.stack([x, y, points[..., 2]], axis=2)
    gap = np.where(gets_there & (there[:, 2] < LOW * problem.radius), np.inf, -np.inf)
    for other in range(1, len(problem.places)):
        if other == point.struck:
            continue
        apart = _distances(world, np.array([*problem.places[other], 0.0]))
        gap = np.minimum(gap, apart - 2.0 * problem.radius - ROOM)
    half_length, half_width = problem.half_sizes
    inside = (np.abs(x).max(axis=1) <= half_length) & (np.abs(y).max(axis=1) <= half_width)
    gap = np.where(inside, np.minimum(gap, 1.0), -np.inf)
    step = p1 - p0
    heading = np.stack(
        [cosine * step[:, 0] - sine * step[:, 1], sine * step[:, 0] + cosine * step[:, 1]], axis=1
    )
    size = np.maximum(np.hypot(*heading.T), 1e-12)
    cut = heading @ point.push / size if point.struck else np.ones(len(paths))
    return turn, gap, cut, distance


def _distances(paths: Rows, point: Rows) -> Rows:
    """Least distance (n,) of paths (n, SAMPLES, 3) from a point (3,)."""
    begin = paths[:, :-1] - point
    along = np.diff(paths, axis=1)
    square = np.maximum((along**2).sum(axis=2), 1e-300)
    part = np.clip(-(begin * along).sum(axis=2) / square, 0.0, 1.0)
    nearest = begin + part[..., np.newaxis] * along
    distances: Rows = np.sqrt((nearest**2).sum(axis=2).min(axis=1))
    return distances
