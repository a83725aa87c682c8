"""Candidate strokes: the waypoints of the cue ball, and direct and cushion routes to them."""

from collections.abc import Iterator, Sequence
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.problem import Limits, Problem, raise_for_clearance
from billiard_shot.planning.statistics import quasi_random
from billiard_shot.planning.within_noise import along_azimuth, strike_alone
from billiard_shot.records import Array
from billiard_shot.scene.player import A, AZIMUTH, B, ELEVATION, SPEED
from billiard_shot.table.motion.cloth import speed_to_arrive

MIN_CUT_COSINE = math.cos(math.radians(82.0))  # of the cuts that are tried
SLACK = 0.95  # of two radii: smallest distance of a path from balls beside it
NEAR_GHOST_BALL = 0.2  # radii: a ball closer to the ghost ball counts as lying there
HIT_DIRECTIONS = 12  # directions that are tried if a ball only has to be hit


class Waypoint(NamedTuple):
    """A position that the centre of the cue ball has to reach."""

    place: Array  # (2,) m
    push: Array  # (2,) unit vector in which it pushes the struck ball; zero if no ball is struck
    struck: int  # index of the struck ball, 0 if no ball is struck
    after: float  # m that balls have to move from there; inaccurate ways have a larger weight


def waypoints(problem: Problem, cushions: int) -> list[Waypoint]:
    """List waypoints of the target; a ball to be potted meets at most `cushions` cushions."""
    point = problem.target.point
    if point is not None:
        return [Waypoint(np.array(point), np.zeros(2), 0, 0.0)]
    if not len(problem.pockets):
        return [
            Waypoint(there - 2.0 * problem.radius * push, push, ball, float(order))
            for ball in problem.balls
            for there in (problem.places[ball],)
            for order, push in enumerate(_pushes(problem, there))
        ]
    return [each for each in _ghosts(problem, cushions) if problem.may_meet(each.struck)]


def _ghosts(problem: Problem, cushions: int) -> Iterator[Waypoint]:
    """Ghost balls of all balls to be potted, for all their ways into pockets."""
    for ball in problem.balls:
        there = problem.places[ball]
        for pocket in problem.pockets:
            for via in sequences(cushions):
                path = mirror_path(problem, there, problem.holes[pocket], via)
                if path is not None and is_clear(problem, path, (0, ball)):
                    push = _unit(path[1] - path[0])
                    after = _length(path) * (1.0 + 2.0 * len(via))
                    yield Waypoint(there - 2.0 * problem.radius * push, push, ball, after)


def combinations(problem: Problem) -> list[Waypoint]:
    """List waypoints at balls that push a ball to be potted into a pocket."""
    if not len(problem.pockets):
        return []
    return [each for ghost in _ghosts(problem, 0) for each in _pushed_by(problem, ghost)]


def _pushed_by(problem: Problem, wanted: Waypoint) -> Iterator[Waypoint]:
    """Waypoints at another ball, which then takes the place of the cue ball at a waypoint."""
    ghost, push, ball, after = wanted
    for other in range(1, len(problem.places)):
        there = problem.places[other]
        if other == ball or not problem.may_meet(other):
            continue
        distance = float(np.hypot(*(ghost - there)))
        line = _unit(ghost - there) if distance > NEAR_GHOST_BALL * problem.radius else push
        cut = float(line @ push)
        if cut > MIN_CUT_COSINE and is_clear(problem, np.array([there, ghost]), (0, other, ball)):
            yield Waypoint(
                there - 2.0 * problem.radius * line,
                line,
                other,
                (after + distance / (2.0 * problem.radius) * 0.2) / cut,
            )


def _pushes(problem: Problem, there: Array) -> list[Array]:
    push = problem.target.push(there)
    if push is not None:
        return [_unit(push)]
    ahead = there - problem.cue_ball
    turns = sorted(np.arange(HIT_DIRECTIONS) - HIT_DIRECTIONS // 2, key=abs)  # the full hit first
    angles = math.atan2(ahead[1], ahead[0]) + np.array(turns) * (2.0 * math.pi / HIT_DIRECTIONS)
    return [np.array([math.cos(angle), math.sin(angle)]) for angle in angles]


def sequences(cushions: int) -> Iterator[tuple[int, ...]]:
    """Sequences of at most `cushions` noses, see boundaries.py, no nose twice in a row."""
    found: list[tuple[int, ...]] = [()]
    while found:
        via = found.pop(0)
        yield via
        if len(via) < cushions:
            found += [(*via, nose) for nose in range(4) if via[-1:] != (nose,)]


def mirror_path(problem: Problem, begin: Array, end: Array, via: Sequence[int]) -> Array | None:
    """Corners (n, 2) of a path that noses reflect like mirrors; None if no such path exists."""
    half_sizes = problem.half_sizes
    if via and not math.isfinite(half_sizes[0]):
        return None
    image = np.array(end, dtype=float)
    images = [image]
    for nose in reversed(via):
        axis, wall = _wall(problem, nose)
        image = image.copy()
        image[axis] = 2.0 * wall - image[axis]
        images.append(image)
    path = [np.array(begin, dtype=float)]
    for step, nose in enumerate(via):
        axis, wall = _wall(problem, nose)
        ahead = images[len(via) - step] - path[-1]
        if ahead[axis] * wall <= 0.0:
            return None
        corner = path[-1] + (wall - path[-1][axis]) / ahead[axis] * ahead
        other, reach = 1 - axis, half_sizes[1 - axis]
        if not abs(corner[other]) <= reach + 1e-9 or (wall - path[-1][axis]) * wall < 0.0:
            return None
        path.append(corner)
    return np.array([*path, end])


def _wall(problem: Problem, nose: int) -> tuple[int, float]:
    """Axis normal to a nose, and the coordinate of a ball's centre that touches the nose [m]."""
    reach = problem.half_sizes[nose // 2]
    return nose // 2, reach if nose % 2 == 0 else -reach


def is_clear(problem: Problem, path: Array, besides: Sequence[int]) -> bool:
    """Whether no ball, except those in `besides`, blocks a path of straight lines (n, 2)."""
    others = [i for i in range(len(problem.places)) if i not in besides]
    if not others:
        return True
    distance: NDArray[np.float64] = distances_from(path, problem.places[others])
    return bool(distance.min() >= 2.0 * SLACK * problem.radius)


def distances_from(paths: Array, points: Array) -> Array:
    """
    Distances of paths of straight lines from points.

    Paths (..., corners, n) and points (..., n), in n dimensions, are broadcast against each other.
    """
    begin, along = paths[..., :-1, :] - points[..., np.newaxis, :], np.diff(paths, axis=-2)
    square = np.maximum((along**2).sum(axis=-1), 1e-300)
    part = np.clip(-(begin * along).sum(axis=-1) / square, 0.0, 1.0)
    nearest = begin + part[..., np.newaxis] * along
    distances: Array = np.sqrt((nearest**2).sum(axis=-1).min(axis=-1))
    return distances


def _unit(vector: Array) -> Array:
    unit: Array = vector / max(float(np.hypot(*vector)), 1e-12)
    return unit


def _length(path: Array) -> float:
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


SPREAD_FACTORS = (0.0, -1.0, 1.0, -2.0, 2.0)  # of `spread`: offsets of the azimuths that are tried
THROW = 0.035  # rad, about two degrees: half of the largest throw in a cut
CUSHION_FACTOR = 3.0  # of the uncertainty of a route by cushions; of its cost, for each cushion
SPEEDS_PER_ROUTE = 5
# b of stun, draw and follow, then half of these; for offset_max 0.5
HEIGHTS = (0.0, -0.4, 0.4, -0.2, 0.2)
LENGTH_FACTORS = (1.0, 0.9, 1.1, 1.25, 1.5)  # distances to roll, relative to the route


class Candidates(NamedTuple):
    """Strokes that may reach the target."""

    strokes: Array  # (n, 5) a, b, elevation, azimuth, speed
    spread: Array  # (n,) rad: uncertainty of the azimuth
    route: NDArray[np.int64]  # (n,) number of the route: its strokes meet the same ball and noses

    def take(self, which: NDArray[np.int64] | NDArray[np.bool_]) -> 'Candidates':
        """Select some of the candidates."""
        return Candidates(self.strokes[which], self.spread[which], self.route[which])


class Route(NamedTuple):
    """A route of the cue ball to a waypoint."""

    azimuth: float
    length: float  # m
    spread: float  # rad: uncertainty of the azimuth
    cost: float  # m: larger for long routes and thin cuts, which succeed less often


def concatenate(parts: list[Candidates]) -> Candidates:
    """Concatenate candidates, with different route numbers in each part."""
    first = 0
    routes = []
    for part in parts:
        routes.append(part.route + first)
        first = int(routes[-1].max(initial=first - 1)) + 1
    return Candidates(
        np.concatenate([part.strokes for part in parts]),
        np.concatenate([part.spread for part in parts]),
        np.concatenate(routes),
    )


def routes_to(problem: Problem, point: Waypoint, cushions: int) -> list[Route]:
    """Find routes to a waypoint that meet at most `cushions` cushions."""
    found = []
    for via in sequences(cushions):
        path = mirror_path(problem, problem.cue_ball, point.place, via)
        if path is None or not is_clear(problem, path, (0, point.struck)):
            continue
        legs = np.diff(path, axis=0)
        if not np.hypot(*legs.T).all():
            continue
        length = float(np.hypot(*legs.T).sum())
        arrival = legs[-1] / np.hypot(*legs[-1])
        cut = float(arrival @ point.push) if point.struck else 1.0
        if cut < MIN_CUT_COSINE or (point.struck and _crosses_struck_ball(problem, path, point)):
            continue
        found.append(
            Route(
                float(np.arctan2(legs[0, 1], legs[0, 0])),
                length,
                spread_of(problem, point, length, cut) * (CUSHION_FACTOR if via else 1.0),
                (length + point.after) / cut * CUSHION_FACTOR ** len(via),
            )
        )
    return found


def spread_of(problem: Problem, point: Waypoint, length: float, cut: float) -> float:
    """Uncertainty of the azimuth at which a waypoint is reached [rad]."""
    if point.struck:
        return THROW * 2.0 * problem.radius * max(cut, 0.2) / length
    radius = getattr(problem.target, 'radius', problem.radius)
    return 0.5 * float(radius) / length


def _crosses_struck_ball(problem: Problem, path: Array, point: Waypoint) -> bool:
    """Whether a path touches the struck ball before it reaches the far side of that ball."""
    before = path[:-1]
    if len(before) < 2:
        return False
    return not is_clear(
        problem, before, tuple(i for i in range(len(problem.places)) if i != point.struck)
    )


def candidates_along(problem: Problem, routes: list[Route]) -> Candidates:
    """
    Build strokes of several speeds and spins along each route.

    The cue is as low as it can be, and turned so that the ball, not the cue, starts along it.
    """
    robot = problem.limits.robot
    heights = 2.0 * robot.offset_max * np.array(HEIGHTS)
    sides: tuple[float, ...] = (0.0,)
    if problem.target.leave is not None:
        sides = (0.0, -0.5 * robot.offset_max, 0.5 * robot.offset_max)
    else:
        heights = heights[:3]
    allowed = problem.limits.allows_azimuth(np.array([route.azimuth for route in routes]))
    rows = [
        (number, side, height, 0.0, route.azimuth, speed)
        for number, route in enumerate(routes)
        if allowed[number]
        for speed in _speeds(problem, route)
        for side in sides
        for height in heights
    ]
    number, strokes = np.split(np.array(rows).reshape(-1, 6), [1], axis=1)
    strokes = raise_for_clearance(problem.scene, problem.limits, problem.limits.clip(strokes))
    playable = ~np.isnan(strokes).any(axis=1)
    route_of = number[playable, 0].astype(np.int64)
    spread = np.array([route.spread for route in routes])[route_of]
    return Candidates(along_azimuth(problem.model, strokes[playable]), spread, route_of)


def _speeds(problem: Problem, route: Route) -> Array:
    robot = problem.limits.robot
    if problem.target.must_rest:
        surface, ways = problem.model.surface, route.length * np.array(LENGTH_FACTORS)
        central = np.array([[0.0, 0.0, 0.0, 0.0, 1.0]])
        forward = strike_alone(problem.model, central).velocity[0, 0]  # of a cue at 1 m/s
        return np.array([speed_to_arrive(surface, way, 0.0) for way in ways]) / forward
    share = problem.target.least_speed
    slowest = max(robot.speed_min, min(0.5, robot.speed_max), share * robot.speed_max)
    return np.geomspace(slowest, robot.speed_max, SPEEDS_PER_ROUTE)


def spread_azimuth(candidates: Candidates) -> Candidates:
    """Repeat each candidate at several azimuths within its spread."""
    many = candidates.take(np.repeat(np.arange(len(candidates.route)), len(SPREAD_FACTORS)))
    many.strokes[:, AZIMUTH] += np.tile(SPREAD_FACTORS, len(candidates.route)) * many.spread
    return many


def strokes_within(limits: Limits, draws: Array, slowest: float) -> Array:
    """Spread draws (n, 5) from 0 to 1 over the strokes within limits, from a speed [m/s] on."""
    robot, (low, high) = limits.robot, limits.elevations
    strokes = np.empty_like(draws)
    radius, angle = robot.offset_max * np.sqrt(draws[:, A]), 2.0 * np.pi * draws[:, B]
    strokes[:, A], strokes[:, B] = radius * np.cos(angle), radius * np.sin(angle)
    strokes[:, ELEVATION] = low + (high - low) * draws[:, ELEVATION]
    half_range = np.radians(robot.azimuth_half_range_deg)
    strokes[:, AZIMUTH] = np.radians(robot.azimuth_deg) + half_range * (
        2.0 * draws[:, AZIMUTH] - 1.0
    )
    strokes[:, SPEED] = slowest * (robot.speed_max / slowest) ** draws[:, SPEED]
    return strokes


def random_candidates(problem: Problem, count: int, skip: int) -> Candidates:
    """Draw quasi-random strokes within all limits, without the first `skip` of the sequence."""
    draws = quasi_random(count, 5, skip)
    draws[:, ELEVATION] **= 3  # mostly low
    strokes = strokes_within(problem.limits, draws, problem.limits.robot.speed_min)
    strokes = raise_for_clearance(problem.scene, problem.limits, strokes)
    strokes = strokes[~np.isnan(strokes).any(axis=1)]
    return Candidates(strokes, np.full(len(strokes), 0.05), np.arange(len(strokes)))
