"""
Whether the cue touches a ball after the strike.

The cue is a straight line that ends in the tip (a point, or a sphere), as the impact has it, and
behind the tip a round shaft: two bodies, each all points within some distance of a half-line along
the cue. The gap to a ball is a distance to a half-line, less a constant.
"""

from collections.abc import Callable
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.table.motion import Motion
from billiard_shot.table.trajectory import Trajectory

Array = NDArray[np.float64]

STEP = 1e-6  # s: a gap that may close within this is touched

SETBACK = 2.0
"""
Where the round shaft begins behind the tip, in half-widths.

There its rounded front is clear of a ball that the tip touches off centre by up to 0.9 radii.
"""


class Shape(NamedTuple):
    """Radius of a ball; of the sphere that is the tip; and half the cue's width [m]."""

    radius: float
    dome: float
    thickness: float


def gap(away: Array, velocity: Array, along: Array, behind: float) -> tuple[float, float]:
    """
    Distance of a ball's centre to a half-line along the cue [m], and its rate of change [m/s].

    Parameters
    ----------
    away, velocity : (3,) float array
        Centre of the ball seen from the tip [m], and how it moves seen from there [m/s].
    along : (3,) float array
        Unit vector along the cue, towards its tip.
    behind : float
        How far behind the tip the half-line ends [m].

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
    Time [s] after the strike at which a ball and the cue touch; inf if not by `until`.

    The cue ball, which the tip touches at first, counts when it touches again.

    Steps as far as the gap cannot have closed, so that no touch is stepped over (conservative
    advancement: Mirtich, "Impulse-based dynamic simulation of rigid body systems", 1996). A
    distance to a half-line is convex, so that within a stretch of smooth motion the gap falls
    behind its tangent by no more than the accelerations make it.

    Parameters
    ----------
    ball : Trajectory
        From the end of the strike on.
    cue : callable
        How far the cue has moved along its axis since then [m], and its speed [m/s], at a time
        [s].
    contact : (3,) float array
        Where the end of the tip was then [m]; `along` (3,) is the unit vector along the cue.
    shape : Shape
    cue_acceleration : float
        Largest acceleration of the cue [m/s^2].
    until : float
        When to stop looking [s].

    """
    rows = ball.rows['acceleration']
    bend = cue_acceleration + float(np.sqrt((rows * rows).sum(axis=1).max()))
    bodies = (
        (shape.dome, shape.radius + shape.dome),
        (SETBACK * shape.thickness, shape.radius + shape.thickness),
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
                room = max(distance - size, 0.0)
                step = min(step, (rate + math.sqrt(rate * rate + 2.0 * bend * room)) / bend)
            if step < STEP:
                return time
            time += step
        time = min(time, end)
    return math.inf
