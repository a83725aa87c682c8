"""Differences between two predictions of a shot: steps, the place of rest, the direction."""

import math

import numpy as np

from billiard_shot.numerics.angles import wrapped
from billiard_shot.shot.shot import Shot
from billiard_shot.table.motion import Cause, Motion
from billiard_shot.table.trajectory import Trajectory

STANDS = (Motion.REST, Motion.SPIN, Motion.POCKETED, Motion.OFF_TABLE)


def steps(shot: Shot) -> int:
    """Count the steps of the impact, the pieces of motion, and the contacts looked for."""
    pieces = sum(len(ball.rows) for ball in shot.run.balls.values())
    return shot.evaluations + pieces + shot.run.searches


def heading(trajectory: Trajectory) -> float:
    """Direction of a ball when it comes to roll, or before it meets something else [rad]."""
    way = trajectory.segments[0]
    causes = trajectory.rows['cause']
    for segment, cause in zip(trajectory.segments, causes, strict=True):
        if cause not in (Cause.START, Cause.OWN) or segment.motion in STANDS:
            break
        way = segment
        if segment.motion == Motion.ROLL:
            break
    return math.atan2(way.velocity[1], way.velocity[0])


def distance(one: Shot, other: Shot) -> float:
    """
    Largest distance between the places where a ball comes to rest in two shots [m].

    Infinite if a ball stops in only one of them. A ball that spins in place has stopped.
    """
    apart = 0.0
    for name, ball in one.run.balls.items():
        twin = other.run.balls[name]
        if _stops(ball) != _stops(twin):
            return math.inf
        apart = max(apart, float(np.linalg.norm(ball.final_position - twin.final_position)))
    return apart


def turn(one: Shot, other: Shot) -> float:
    """Angle between the directions in which the struck ball goes in two shots [rad]."""
    angle = heading(one.trajectory) - heading(other.trajectory)
    return abs(wrapped(angle))


def _stops(ball: Trajectory) -> bool:
    return ball.segments[-1].motion in STANDS
