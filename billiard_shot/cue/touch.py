"""
Find when the cue touches a ball after the strike.

The cue consists of two bodies: the tip (a point, or a sphere, as in the impact) and the round
shaft behind it. Each body is the set of points within some distance of a half-line along the cue.
So the gap to a ball is the distance to a half-line, minus a constant.
"""

from collections.abc import Callable
import math
from typing import NamedTuple

import numpy as np

from billiard_shot.records import Array
from billiard_shot.table.motion import Motion
from billiard_shot.table.trajectory import Trajectory

MIN_STEP = 1e-6  # s: a gap that may close within this time counts as a touch

SETBACK = 2.0
"""
Distance from the tip to the start of the round shaft, in half-widths of the shaft.

At this distance the rounded front of the shaft is clear of the ball, for offsets of up to 0.9
radii.
"""


class Shape(NamedTuple):
    """Radii of a ball, of the sphere of the tip's curvature, and of the shaft [m]."""

    ball: float
    tip: float
    shaft: float


def gap(away: Array, velocity: Array, along: Array, behind: float) -> tuple[float, float]:
    """
    Distance of a ball's centre to a half-line along the cue [m], and its rate of change [m/s].

    Parameters
    ----------
    away, velocity : (3,) float array
        Centre [m] and velocity [m/s] of the ball relative to the tip.
    along : (3,) float array
        Unit vector along the cue, towards its tip.
    behind : float
        Distance from the tip back to the end of the half-line [m].

    """
    ahead = float(away @ along)
    off = away + max(-ahead, behind) * along
    distance = math.sqrt(off @ off)
    return distance, float(velocity @ off) / distance if distance > 0.0 else 0.0


def first_touch(
    ball: Trajectory,
    cue: Callable[[float], tuple[float, float]],
    contact: Array,
    along: Array,
    shape: Shape,
    cue_acceleration: float,
    until: float,
) -> float:
    """
    Time [s] after the strike at which a ball and the cue touch; inf if they do not by `until`.

    For the cue ball, which the tip touches at the start, this is the next touch.

    Each step is so short that the gap cannot close within it (conservative advancement: Mirtich,
    "Impulse-based dynamic simulation of rigid body systems", 1996). The distance to a half-line is
    convex. So during smooth motion the accelerations bound how far the gap can fall below its
    tangent.

    Parameters
    ----------
    ball : Trajectory
        Trajectory of the ball from the end of the strike on.
    cue : callable
        Returns the distance that the cue has moved along its axis since the strike [m], and its
        speed [m/s], at a time [s].
    contact : (3,) float array
        Position of the tip at the end of the strike [m].
    along : (3,) float array
        Unit vector along the cue.
    shape : Shape
    cue_acceleration : float
        Largest acceleration of the cue [m/s^2].
    until : float
        End of the search [s].

    """
    rows = ball.rows['acceleration']
    bend = cue_acceleration + float(np.sqrt((rows * rows).sum(axis=1).max()))
    bodies = (
        (shape.tip, shape.ball + shape.tip),
        (SETBACK * shape.shaft, shape.ball + shape.shaft),
    )
    time = 0.0
    for segment in ball.segments:
        if segment.motion in (Motion.POCKETED, Motion.OFF_TABLE):
            return math.inf
        end = min(segment.end, until)
        while time < end:
            dt = time - segment.start
            moved, speed = cue(time)
            away = (
                segment.position
                - contact
                + (segment.velocity + 0.5 * segment.acceleration * dt) * dt
                - moved * along
            )
            velocity = segment.velocity + segment.acceleration * dt - speed * along
            step = math.inf
            for behind, size in bodies:
                distance, rate = gap(away, velocity, along, behind)
                free = max(distance - size, 0.0)
                step = min(step, (rate + math.sqrt(rate * rate + 2.0 * bend * free)) / bend)
            if step < MIN_STEP:
                return time
            time += step
        time = min(time, end)
    return math.inf
