"""Candidate strokes: direct and cushion routes of the cue ball to its waypoints."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import Limits, raise_for_clearance
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.statistics import quasi_random
from billiard_shot.planning.strikes import along_azimuth, strike_alone
from billiard_shot.planning.targets import Break, Pot, Rest
from billiard_shot.planning.waypoints import (
    is_clear,
    MIN_CUT_COSINE,
    mirror_path,
    sequences,
    Waypoint,
)
from billiard_shot.records import Array
from billiard_shot.scene.player import A, AZIMUTH, B, ELEVATION, SPEED
from billiard_shot.table.cloth import speed_to_arrive

SPREAD_FACTORS = (0.0, -1.0, 1.0, -2.0, 2.0)  # of `spread`: offsets of the azimuths that are tried
THROW = 0.035  # rad, about two degrees: half of the largest throw in a cut
CUSHION_FACTOR = 3.0  # of the uncertainty of a route by cushions; of its cost, for each cushion
SPEEDS_PER_ROUTE = 5
BREAK_SPEED = 0.7  # of the largest speed: slower breaks are not candidates
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
    if isinstance(problem.target, Pot) and problem.target.leave is not None:
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
    if isinstance(problem.target, Rest):
        surface, ways = problem.model.surface, route.length * np.array(LENGTH_FACTORS)
        central = np.array([[0.0, 0.0, 0.0, 0.0, 1.0]])
        forward = strike_alone(problem.model, central).velocity[0, 0]  # of a cue at 1 m/s
        return np.array([speed_to_arrive(surface, way, 0.0) for way in ways]) / forward
    slowest = max(robot.speed_min, min(0.5, robot.speed_max))
    if isinstance(problem.target, Break):
        slowest = max(slowest, BREAK_SPEED * robot.speed_max)
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
