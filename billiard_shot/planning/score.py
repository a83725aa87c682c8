"""How near played strokes came to their target."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.motions import FAR, Motions
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.strikes import Rows
from billiard_shot.planning.targets import Gate, Hit, Pass, Pot, Rest
from billiard_shot.table.motion import OFF_TABLE, POCKETED
from billiard_shot.table.simulate import BatchRecording

Yes = NDArray[np.bool_]
# Steps on the way to a target that are missing: one each, so that whoever got a step farther is
# nearer. Lengths [m] add to them, far below one.
STEP = 1.0
LONGEST = 0.99


def score(problem: Problem, recording: BatchRecording, motions: Motions) -> tuple[Yes, Rows]:
    """Whether each table (n,) reached the target, and by how much it missed, see `Outcomes`."""
    cue = motions.of(motions.ball == 0)
    match problem.target:
        case Rest():
            away = recording.balls['position'][:, 0, :2] - problem.target.rest
            miss = _short(np.hypot(*away.T) - problem.target.radius)
        case Pass():
            near = cue.nearest(np.array(problem.target.passing))
            miss = _short(near - problem.target.radius)
        case Gate():
            miss = _gate(cue, np.array(problem.target.gate))
        case Hit():
            miss = _hit(problem, problem.target, recording, motions, cue)
        case Pot():
            miss = _pot(problem, problem.target, recording, motions)
    lost = recording.balls['motion'][:, 0] >= POCKETED
    off = (recording.balls['motion'] == OFF_TABLE).any(axis=1)
    foul = lost | off
    if problem.first:
        foul |= recording.balls['first_contact'][:, 0] != problem.first
    miss = miss + STEP * foul
    return miss == 0.0, miss


def _short(gap: Rows) -> Rows:
    return np.clip(gap, 0.0, LONGEST)


def _gate(cue: Motions, ends: Rows) -> Rows:
    """Distance of the path from a line between two points; 0 where it crosses it."""
    begin, after = cue.corners[:, :-1], cue.corners[:, 1:]
    line = ends[1] - ends[0]

    def side(points: Rows) -> Rows:
        away = points - ends[0]
        across: Rows = line[0] * away[..., 1] - line[1] * away[..., 0]
        return across

    first, second = side(begin), side(after)
    with np.errstate(invalid='ignore', divide='ignore'):
        part = first / (first - second)
        along = ((begin + part[..., np.newaxis] * (after - begin)) - ends[0]) @ line
        within = (along >= 0.0) & (along <= line @ line) & (first * second <= 0.0)
    crossed = cue.least(np.where(within.any(axis=1), 0.0, FAR))
    nearest = cue.nearest(ends.mean(axis=0))
    return np.where(crossed == 0.0, 0.0, np.clip(nearest, 1e-6, LONGEST))


def _hit(
    problem: Problem, target: Hit, recording: BatchRecording, motions: Motions, cue: Motions
) -> Rows:
    """Meet the wanted ball first, then at the right place, or in the right direction."""
    ball = problem.places[problem.ball]
    reached = recording.balls['first_contact'][:, 0] == problem.ball
    before = cue.of(cue.time < motions.met(0)[cue.table])
    miss = STEP * ~reached + np.where(
        reached, 0.0, np.clip(before.nearest(ball) - 2.0 * problem.radius, 1e-6, LONGEST)
    )
    if target.direction is None and target.at is None:
        return miss
    # The first stretch of the ball, and of the cue ball, after their meeting.
    own = motions.of((motions.ball == problem.ball) & motions.after_ball)
    first = _first(own)
    beyond = np.full(motions.tables, LONGEST)
    if target.direction is not None:
        wanted = np.arctan2(target.direction[1], target.direction[0])
        heading = np.arctan2(own.velocity[first, 1], own.velocity[first, 0])
        turn = np.abs(np.remainder(heading - wanted + np.pi, 2.0 * np.pi) - np.pi)
        beyond[own.table[first]] = (turn - np.radians(target.within_deg)) / np.pi
    elif target.at is not None:
        struck = cue.of(cue.after_ball)
        there = struck.place[_first(struck), :2] - ball
        touched = problem.radius * there / np.hypot(*there.T)[:, np.newaxis]
        wanted = np.array(target.at) - ball
        wanted *= problem.radius / np.hypot(*wanted)
        beyond[struck.table[_first(struck)]] = np.hypot(*(touched - wanted).T) - target.radius
    return miss + STEP * ~reached + np.where(reached, _short(beyond), 0.0)


def _first(motions: Motions) -> NDArray[np.int64]:
    """Index of the first stretch of each table that has one, where there is one ball."""
    first: NDArray[np.int64] = np.unique(motions.table, return_index=True)[1]
    return first


def _pot(problem: Problem, target: Pot, recording: BatchRecording, motions: Motions) -> Rows:
    """Touch the ball, bring it to a pocket, and leave the cue ball where it is wanted."""
    own = motions.of(motions.ball == problem.ball)
    touched = np.isfinite(motions.met(problem.ball))
    others = motions.of((motions.ball != problem.ball) & (motions.duration > 0.0))
    near = others.nearest(problem.places[problem.ball]) - 2.0 * problem.radius
    to_pocket = np.min([own.nearest(problem.hole(pocket)) for pocket in problem.pockets], axis=0)
    into = recording.balls['pocket'][:, problem.ball]
    potted = np.isin(into, problem.pockets)
    miss = np.where(touched, np.clip(to_pocket, 1e-6, LONGEST), STEP + _short(near))
    miss = np.where(potted, 0.0, miss)
    if target.leave is not None:
        away = np.hypot(*(recording.balls['position'][:, 0, :2] - target.leave).T) - target.radius
        miss = np.where(potted, _short(away), STEP + miss)
    return miss
