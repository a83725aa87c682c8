"""
Where the cue ball has to come to: ghost balls, behind real and mirrored pockets.

A ball leaves along the line of centres, so that the cue ball must be where it would touch it on
the line to the pocket, the "ghost ball". A cushion is a mirror: a ball that is to reach a pocket
by way of it aims at the pocket's image. Throw, spin and real cushions change that by some degrees,
which is left to the search.
"""

from collections.abc import Iterator, Sequence
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.problem import point_of, Problem
from billiard_shot.planning.strikes import Rows
from billiard_shot.planning.targets import Hit

THINNEST = math.cos(math.radians(82.0))  # of cuts that are tried
SLACK = 0.95  # part of two radii that paths have to keep from balls beside them
NEAR = 0.2  # radii: a ball that is so near to the ghost ball is there already
ROUND = 12  # directions in which a ball is hit that only has to be hit


class Waypoint(NamedTuple):
    """A place for the centre of the cue ball."""

    place: Rows  # (2,) m
    push: Rows  # (2,) unit vector in which it pushes the ball there; zero: there is none
    struck: int  # index of that ball, 0: none
    after: float  # m that balls have to go from there, longer for what takes more luck


def waypoints(problem: Problem, cushions: int) -> list[Waypoint]:
    """All that may do; balls that are to be potted go by up to so many cushions."""
    ball, radius = problem.ball, problem.radius
    point = point_of(problem.target)
    if point is not None:
        return [Waypoint(np.array(point), np.zeros(2), 0, 0.0)]
    there = problem.places[ball]
    if isinstance(problem.target, Hit):
        return [
            Waypoint(there - 2.0 * radius * push, push, ball, float(order))
            for order, push in enumerate(_pushes(problem, problem.target))
        ]
    found = []
    for pocket in problem.pockets:
        hole = problem.hole(pocket)
        for via in sequences(cushions):
            path = reflected(problem, there, hole, via)
            if path is None or not clear(problem, path, (0, ball)):
                continue
            push = _unit(path[1] - path[0])
            after = _length(path) * (1.0 + 2.0 * len(via))
            ghost = there - 2.0 * radius * push
            if problem.first in (0, ball):
                found.append(Waypoint(ghost, push, ball, after))
            if not via:
                found += _combinations(problem, ghost, push, after)
    return found


def _combinations(problem: Problem, ghost: Rows, push: Rows, after: float) -> Iterator[Waypoint]:
    """Ways to send another ball to where it pushes the one that is wanted."""
    for other in range(1, len(problem.places)):
        there = problem.places[other]
        if other == problem.ball or problem.first not in (0, other):
            continue
        distance = float(np.hypot(*(ghost - there)))
        line = _unit(ghost - there) if distance > NEAR * problem.radius else push
        cut = float(line @ push)
        if cut > THINNEST and clear(problem, np.array([there, ghost]), (0, other, problem.ball)):
            yield Waypoint(
                there - 2.0 * problem.radius * line,
                line,
                other,
                (after + distance / (2.0 * problem.radius) * 0.2) / cut,
            )


def _pushes(problem: Problem, target: Hit) -> list[Rows]:
    if target.direction is not None:
        return [_unit(np.array(target.direction))]
    there = problem.places[problem.ball]
    if target.at is not None:
        return [_unit(there - target.at)]
    ahead = there - problem.cue_ball
    turns = sorted(np.arange(ROUND) - ROUND // 2, key=abs)  # the full hit first
    angles = math.atan2(ahead[1], ahead[0]) + np.array(turns) * (2.0 * math.pi / ROUND)
    return [np.array([math.cos(angle), math.sin(angle)]) for angle in angles]


def sequences(cushions: int) -> Iterator[tuple[int, ...]]:
    """Sequences of up to so many noses, see rolling_boundary.py, none twice in a row."""
    found: list[tuple[int, ...]] = [()]
    while found:
        via = found.pop(0)
        yield via
        if len(via) < cushions:
            found += [(*via, nose) for nose in range(4) if via[-1:] != (nose,)]


def reflected(problem: Problem, begin: Rows, end: Rows, via: Sequence[int]) -> Rows | None:
    """Corners (n, 2) of a path by way of some noses as if they were mirrors; None: there is no."""
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
    """Axis across a nose, and where the centre of a ball is that touches it [m]."""
    reach = problem.half_sizes[nose // 2]
    return nose // 2, reach if nose % 2 == 0 else -reach


def clear(problem: Problem, path: Rows, besides: Sequence[int]) -> bool:
    """Whether no ball besides some is in the way of a path of straight lines (n, 2)."""
    others = [i for i in range(len(problem.places)) if i not in besides]
    if not others:
        return True
    distance: NDArray[np.float64] = distances_from(path, problem.places[others])
    return bool(distance.min() >= 2.0 * SLACK * problem.radius)


def distances_from(path: Rows, points: Rows) -> Rows:
    """Distances (points,) of points (points, 2) from a path of straight lines."""
    begin, along = path[:-1], np.diff(path, axis=0)
    away = points[:, np.newaxis] - begin
    square = np.maximum((along**2).sum(axis=1), 1e-300)
    part = np.clip((away * along).sum(axis=2) / square, 0.0, 1.0)
    nearest = away - part[:, :, np.newaxis] * along
    distances: Rows = np.sqrt((nearest**2).sum(axis=2)).min(axis=1)
    return distances


def _unit(vector: Rows) -> Rows:
    unit: Rows = vector / max(float(np.hypot(*vector)), 1e-12)
    return unit


def _length(path: Rows) -> float:
    return float(np.hypot(*np.diff(path, axis=0).T).sum())
