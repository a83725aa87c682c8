"""
The kinds of motion, each at constant acceleration, and the rows in which they are written down.

A segment is one row of numbers: from its time on, until the next row's,
    position = p + v dt + a dt^2 / 2 ,   velocity = v + a dt ,   spin = w + w' dt .
"""
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused


class Motion(IntEnum):
    """What a ball is doing; the numbers are those of billiard_shot_msgs/msg/BallTrajectory."""

    REST = 0
    SLIDE = 1  # on the cloth, its lowest point slips
    ROLL = 2  # on the cloth, without slip
    SPIN = 3  # turns in place about the vertical
    FLIGHT = 4
    POCKETED = 5  # lies in a pocket
    OFF_TABLE = 6  # left the table, where it was last seen


REST, SLIDE, ROLL, SPIN, FLIGHT, POCKETED, OFF_TABLE = (int(motion) for motion in Motion)


class Cause(IntEnum):
    """What began a segment."""

    START = 0
    OWN = 1  # the motion before it was over: it stopped slipping, landed ...
    BALL = 2
    CUSHION = 3
    CLUSTER = 4  # an impact of more than two bodies
    POCKET = 5
    OFF = 6


START, OWN, BALL, CUSHION, CLUSTER, POCKET, OFF = (int(cause) for cause in Cause)

# columns of a row
TIME, MOTION = 0, 1
POSITION, VELOCITY, ACCELERATION = 2, 5, 8  # three each
ANGULAR, ANGULAR_ACCELERATION = 11, 14
CAUSE = 17
COLUMNS = 18

# A ball on its way is such a row too, with more columns. SPIN_ENDS: what ends is only the spin
# about the vertical. FALL: speed [m/s] with which a ball comes down after a pause (flight.py).
# HOPS: bounces since the last impact with anything but the cloth. COUNT: segments written so far.
END, SPIN_ENDS, FALL, HOPS, COUNT = 18, 19, 20, 21, 22
STATE = 23

HEIGHT, CLIMB, VERTICAL_SPIN = POSITION + 2, VELOCITY + 2, ANGULAR + 2


@fused
def start(
    position: NDArray[np.float64], velocity: NDArray[np.float64], spin: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Ball on its way from this state at time 0."""
    ball = np.zeros(STATE)
    for i in range(3):
        ball[POSITION + i] = position[i]
        ball[VELOCITY + i] = velocity[i]
        ball[ANGULAR + i] = spin[i]
    return ball


@fused
def record(ball: NDArray[np.float64], segments: NDArray[np.float64]) -> None:
    """Write the ball's motion down as its next segment; without room for it, only count it."""
    count = int(ball[COUNT])
    if count < segments.shape[0]:
        for i in range(COLUMNS):
            segments[count, i] = ball[i]
    ball[COUNT] += 1.0


@fused
def advance(ball: NDArray[np.float64], time: float) -> None:
    """Move the ball on to a time."""
    dt = time - ball[TIME]
    for i in range(3):
        change = ball[ACCELERATION + i] * dt
        ball[POSITION + i] += (ball[VELOCITY + i] + 0.5 * change) * dt
        ball[VELOCITY + i] += change
        ball[ANGULAR + i] += ball[ANGULAR_ACCELERATION + i] * dt
    ball[TIME] = time


@fused
def halt(ball: NDArray[np.float64], motion: int) -> None:
    """Stop the ball where it is, for good."""
    for i in range(3):
        ball[VELOCITY + i] = 0.0
        ball[ACCELERATION + i] = 0.0
        ball[ANGULAR + i] = 0.0
        ball[ANGULAR_ACCELERATION + i] = 0.0
    ball[MOTION] = motion
    ball[END] = np.inf
