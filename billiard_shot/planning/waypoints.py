"""
Waypoints of the cue ball: ghost balls for real and mirrored pockets.

A struck ball leaves along the line of centres. The cue ball must therefore touch it opposite to
the pocket: at the "ghost ball". A cushion acts as a mirror: a ball that reaches a pocket by way of
a cushion is aimed at the mirror image of the pocket. Throw, spin and real cushions change these
directions by some degrees, which the search finds.
"""

from collections.abc import Iterator, Sequence
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.problem import point_of, Problem
from billiard_shot.planning.targets import Hit, Pot
from billiard_shot.records import Array

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
    point = point_of(problem.target)
    if point is not None:
        return [Waypoint(np.array(point), np.zeros(2), 0, 0.0)]
    if not isinstance(problem.target, Pot):
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
    if not isinstance(problem.target, Pot):
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
    target = problem.target
    if isinstance(target, Hit) and target.direction is not None:
        return [_unit(np.array(target.direction))]
    if isinstance(target, Hit) and target.at is not None:
        return [_unit(there - target.at)]
    ahead = there - problem.cue_ball
    turns = sorted(np.arange(HIT_DIRECTIONS) - HIT_DIRECTIONS // 2, key=abs)  # the full hit first
    angles = math.atan2(ahead[1], ahead[0]) + np.array(turns) * (2.0 * math.pi / HIT_DIRECTIONS)
    return [np.array([math.cos(angle), math.sin(angle)]) for angle in angles]


def sequences(cushions: int) -> Iterator[tuple[int, ...]]:
    """Sequences of at most `cushions` noses, see rolling_boundary.py, no nose twice in a row."""
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
