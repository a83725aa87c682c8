"""Strokes to begin with: the cue ball's ways to its waypoints, straight and by cushions."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import A, AZIMUTH, B, raised, SPEED
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.strikes import Rows, strikes_of
from billiard_shot.planning.targets import Pot, Rest
from billiard_shot.planning.waypoints import clear, reflected, sequences, THINNEST, Waypoint

FAN = (0.0, -1.0, 1.0, -2.0, 2.0)  # parts of `spread` by which aims are turned
THROW = 0.035  # rad, about two degrees: half of what throw turns balls by in a cut
CUSHION = 3.0  # times less sure is what comes back from a cushion
SPEEDS = 5
HEIGHTS = (0.0, -0.4, 0.4, -0.2, 0.2)  # b of draw, stun and follow, in parts of the largest 0.5
LENGTHS = (1.0, 0.9, 1.1, 1.25, 1.5)  # parts of the straight way that a ball may have to roll


class Guesses(NamedTuple):
    """Strokes that may reach the target."""

    strokes: Rows  # (n, 5) a, b, elevation, azimuth, speed
    spread: Rows  # (n,) rad, within which the azimuth still has to be sought
    way: NDArray[np.int64]  # (n,) number of the way they take: alike in what happens

    def take(self, which: NDArray[np.int64] | NDArray[np.bool_]) -> 'Guesses':
        """Pick some of them."""
        return Guesses(self.strokes[which], self.spread[which], self.way[which])


class Way(NamedTuple):
    """A way of the cue ball to a waypoint."""

    azimuth: float
    length: float  # m
    spread: float  # rad
    cost: float  # m: the longer and thinner, the less likely


def joined(parts: list[Guesses]) -> Guesses:
    """All guesses of some lists; their ways are told apart."""
    begin = 0
    ways = []
    for part in parts:
        ways.append(part.way + begin)
        begin = int(ways[-1].max(initial=begin - 1)) + 1
    return Guesses(
        np.concatenate([part.strokes for part in parts]),
        np.concatenate([part.spread for part in parts]),
        np.concatenate(ways),
    )


def ways_to(problem: Problem, point: Waypoint, cushions: int) -> list[Way]:
    """Ways to a waypoint by up to so many cushions."""
    found = []
    for via in sequences(cushions):
        path = reflected(problem, problem.cue_ball, point.place, via)
        if path is None or not clear(problem, path, (0, point.struck)):
            continue
        legs = np.diff(path, axis=0)
        if not np.hypot(*legs.T).all():
            continue
        length = float(np.hypot(*legs.T).sum())
        arrival = legs[-1] / np.hypot(*legs[-1])
        cut = float(arrival @ point.push) if point.struck else 1.0
        if cut < THINNEST or (point.struck and _through(problem, path, point)):
            continue
        found.append(
            Way(
                float(np.arctan2(legs[0, 1], legs[0, 0])),
                length,
                spread_of(problem, point, length, cut) * (CUSHION if via else 1.0),
                (length + point.after) / cut * CUSHION ** len(via),
            )
        )
    return found


def spread_of(problem: Problem, point: Waypoint, length: float, cut: float) -> float:
    """Angle by which the aim at a waypoint may have to be turned [rad]."""
    if point.struck:
        return THROW * 2.0 * problem.radius * max(cut, 0.2) / length
    radius = getattr(problem.target, 'radius', problem.radius)
    return 0.5 * float(radius) / length


def _through(problem: Problem, path: Rows, point: Waypoint) -> bool:
    """Whether a path would touch the ball on its way to the far side of it."""
    before = path[:-1]
    if len(before) < 2:
        return False
    return not clear(
        problem, before, tuple(i for i in range(len(problem.places)) if i != point.struck)
    )


def guesses_along(problem: Problem, ways: list[Way]) -> Guesses:
    """Strokes of several speeds and spins along each way, as low as the cue can be."""
    robot = problem.limits.robot
    heights = 2.0 * robot.offset_max * np.array(HEIGHTS)
    sides: tuple[float, ...] = (0.0,)
    if isinstance(problem.target, Pot) and problem.target.leave is not None:
        sides = (0.0, -0.5 * robot.offset_max, 0.5 * robot.offset_max)
    else:
        heights = heights[:3]
    grid = [(side, height) for side in sides for height in heights]
    strokes, spreads, numbers = [], [], []
    for number, way in enumerate(ways):
        for speed in _speeds(problem, way):
            for side, height in grid:
                strokes.append((side, height, 0.0, way.azimuth, speed))
                spreads.append(way.spread)
                numbers.append(number)
    made = Guesses(
        np.array(strokes).reshape(-1, 5), np.array(spreads), np.array(numbers, np.int64)
    )
    made.strokes[:, :] = problem.limits.inside(made.strokes)
    allowed = problem.limits.allows(np.array([way.azimuth for way in ways]))[made.way]
    return aimed(problem, made.take(allowed))


def _speeds(problem: Problem, way: Way) -> Rows:
    robot = problem.limits.robot
    if isinstance(problem.target, Rest):
        reach = _reach(problem)
        return np.sqrt(way.length * np.array(LENGTHS) / reach)
    least = max(robot.speed_min, min(0.5, robot.speed_max))
    return np.geomspace(least, robot.speed_max, SPEEDS)


def _reach(problem: Problem) -> float:
    """
    How far the ball rolls after a central stroke at 1 m/s [m]; at another speed, v^2 times that.

    It leaves at v, slides until 5/7 of that, and rolls to rest: slide and roll take
    12/49 v^2 / (mu g) and 25/49 v^2 / (2 mu_r g).
    """
    ball = problem.model.surface
    v = float(strikes_of(problem.scene, problem.model, np.zeros((1, 3)))[0, 0])
    friction, resistance = ball.sliding_friction, max(ball.rolling_resistance, 1e-4)
    slide = 12.0 / 49.0 / (friction * ball.gravity) if friction > 0.0 else 0.0
    roll = 25.0 / 98.0 / (resistance * ball.gravity)
    return v * v * (slide + roll)


def aimed(problem: Problem, guesses: Guesses) -> Guesses:
    """Raise the cue where it must be, and turn strokes so that the ball starts along the way."""
    strokes = raised(problem.scene, problem.limits, guesses.strokes)
    playable = np.flatnonzero(~np.isnan(strokes).any(axis=1))
    strokes, found = strokes[playable], guesses.take(playable)
    # what a strike gives does not depend on speed and azimuth
    kinds, which = np.unique(strokes[:, :3].round(6), axis=0, return_inverse=True)
    given = strikes_of(problem.scene, problem.model, kinds)[which.ravel()]
    strokes[:, AZIMUTH] -= np.nan_to_num(np.arctan2(given[:, 1], given[:, 0]))
    return Guesses(strokes, found.spread, found.way)


def fanned(guesses: Guesses) -> Guesses:
    """Each guess several times, turned by parts of its spread."""
    many = guesses.take(np.repeat(np.arange(len(guesses.way)), len(FAN)))
    many.strokes[:, AZIMUTH] += np.tile(FAN, len(guesses.way)) * many.spread
    return many


def random_guesses(problem: Problem, count: int, skip: int) -> Guesses:
    """Quasi-random strokes all over the limits, the first `skip` of the sequence left out."""
    from scipy.stats import qmc

    robot = problem.limits.robot
    sequence = qmc.Halton(5, scramble=False)
    sequence.fast_forward(1 + skip)
    draws = sequence.random(count)
    strokes = np.empty((count, 5))
    radius, angle = robot.offset_max * np.sqrt(draws[:, 0]), 2.0 * np.pi * draws[:, 1]
    strokes[:, A], strokes[:, B] = radius * np.cos(angle), radius * np.sin(angle)
    low, high = problem.limits.elevations
    strokes[:, 2] = low + (high - low) * draws[:, 2] ** 3  # low ones mostly
    reach = np.radians(robot.azimuth_range_deg)
    strokes[:, AZIMUTH] = np.radians(robot.azimuth_deg) + reach * (2.0 * draws[:, 3] - 1.0)
    strokes[:, SPEED] = robot.speed_min * (robot.speed_max / robot.speed_min) ** draws[:, 4]
    strokes = raised(problem.scene, problem.limits, strokes)
    strokes = strokes[~np.isnan(strokes).any(axis=1)]
    return Guesses(strokes, np.full(len(strokes), 0.05), np.arange(len(strokes)))
