"""Penalties of simulated strokes: how far they are from reaching the target."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.problem import Problem
from billiard_shot.planning.segments import FAR, Segments
from billiard_shot.planning.strikes import Array
from billiard_shot.planning.targets import Gate, Hit, Pass, Pot, Rest
from billiard_shot.table.motion import OFF_TABLE, POCKETED
from billiard_shot.table.simulate import BatchRecording

BoolArray = NDArray[np.bool_]
# Penalty of each missing step towards the target. The remaining distance [m] is added; it is less
# than a step, so that a stroke that comes a step farther has the smaller penalty.
STEP = 1.0
MAX_DISTANCE_PENALTY = 0.99


def score(
    problem: Problem, recording: BatchRecording, segments: Segments
) -> tuple[BoolArray, Array]:
    """Success (n,) and penalty (n,) of each table, see `Outcomes`."""
    cue = segments.of(segments.ball == 0)
    match problem.target:
        case Rest():
            away = recording.balls['position'][:, 0, :2] - problem.target.rest
            penalty = _distance_penalty(np.hypot(*away.T) - problem.target.radius)
        case Pass():
            near = cue.nearest(np.array(problem.target.passing))
            penalty = _distance_penalty(near - problem.target.radius)
        case Gate():
            penalty = _gate(cue, np.array(problem.target.gate))
        case Hit():
            penalty = _hit(problem, problem.target, recording, segments, cue)
        case Pot():
            penalty = _pot(problem, problem.target, recording, segments)
    lost = recording.balls['motion'][:, 0] >= POCKETED
    off = (recording.balls['motion'] == OFF_TABLE).any(axis=1)
    foul = lost | off
    if problem.first:
        foul |= recording.balls['first_contact'][:, 0] != problem.first
    penalty = penalty + STEP * foul
    return penalty == 0.0, penalty


def _distance_penalty(gap: Array) -> Array:
    return np.clip(gap, 0.0, MAX_DISTANCE_PENALTY)


def _gate(cue: Segments, ends: Array) -> Array:
    """Distance of the path from the line between two points; 0 if the path crosses it."""
    begin, after = cue.corners[:, :-1], cue.corners[:, 1:]
    line = ends[1] - ends[0]

    def side(points: Array) -> Array:
        away = points - ends[0]
        across: Array = line[0] * away[..., 1] - line[1] * away[..., 0]
        return across

    first, second = side(begin), side(after)
    with np.errstate(invalid='ignore', divide='ignore'):
        part = first / (first - second)
        along = ((begin + part[..., np.newaxis] * (after - begin)) - ends[0]) @ line
        within = (along >= 0.0) & (along <= line @ line) & (first * second <= 0.0)
    crossed = cue.minimum(np.where(within.any(axis=1), 0.0, FAR))
    nearest = cue.nearest(ends.mean(axis=0))
    return np.where(crossed == 0.0, 0.0, np.clip(nearest, 1e-6, MAX_DISTANCE_PENALTY))


def _hit(
    problem: Problem, target: Hit, recording: BatchRecording, segments: Segments, cue: Segments
) -> Array:
    """Penalty for the first contact with another ball, the wrong place, or the wrong direction."""
    ball = problem.places[problem.ball]
    reached = recording.balls['first_contact'][:, 0] == problem.ball
    before = cue.of(cue.time < segments.met(0)[cue.table])
    penalty = STEP * ~reached + np.where(
        reached,
        0.0,
        np.clip(before.nearest(ball) - 2.0 * problem.radius, 1e-6, MAX_DISTANCE_PENALTY),
    )
    if target.direction is None and target.at is None:
        return penalty
    # The first segment of the ball, and of the cue ball, after their collision.
    own = segments.of((segments.ball == problem.ball) & segments.after_ball)
    first = _first_segment(own)
    beyond = np.full(segments.tables, MAX_DISTANCE_PENALTY)
    if target.direction is not None:
        wanted = np.arctan2(target.direction[1], target.direction[0])
        heading = np.arctan2(own.velocity[first, 1], own.velocity[first, 0])
        turn = np.abs(np.remainder(heading - wanted + np.pi, 2.0 * np.pi) - np.pi)
        beyond[own.table[first]] = (turn - np.radians(target.direction_tolerance_deg)) / np.pi
    elif target.at is not None:
        struck = cue.of(cue.after_ball)
        there = struck.place[_first_segment(struck), :2] - ball
        touched = problem.radius * there / np.hypot(*there.T)[:, np.newaxis]
        wanted = np.array(target.at) - ball
        wanted *= problem.radius / np.hypot(*wanted)
        beyond[struck.table[_first_segment(struck)]] = (
            np.hypot(*(touched - wanted).T) - target.radius
        )
    return penalty + STEP * ~reached + np.where(reached, _distance_penalty(beyond), 0.0)


def _first_segment(segments: Segments) -> NDArray[np.int64]:
    """Index of the first segment of each table that has one; all segments are of one ball."""
    first: NDArray[np.int64] = np.unique(segments.table, return_index=True)[1]
    return first


def _pot(problem: Problem, target: Pot, recording: BatchRecording, segments: Segments) -> Array:
    """Penalty for a ball that is not touched or not potted, or for a wrong leave."""
    own = segments.of(segments.ball == problem.ball)
    touched = np.isfinite(segments.met(problem.ball))
    others = segments.of((segments.ball != problem.ball) & (segments.duration > 0.0))
    near = others.nearest(problem.places[problem.ball]) - 2.0 * problem.radius
    to_pocket = np.min([own.nearest(problem.hole(pocket)) for pocket in problem.pockets], axis=0)
    into = recording.balls['pocket'][:, problem.ball]
    potted = np.isin(into, problem.pockets)
    penalty = np.where(
        touched, np.clip(to_pocket, 1e-6, MAX_DISTANCE_PENALTY), STEP + _distance_penalty(near)
    )
    penalty = np.where(potted, 0.0, penalty)
    if target.leave is not None:
        away = np.hypot(*(recording.balls['position'][:, 0, :2] - target.leave).T) - target.radius
        penalty = np.where(potted, _distance_penalty(away), STEP + penalty)
    return penalty
