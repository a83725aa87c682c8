"""
The kinds of motion, each at constant acceleration, and the rows in which they are written down.

A segment is one row of numbers: from its time on, until the next row's,
    position = p + v dt + a dt^2 / 2 ,   velocity = v + a dt ,   spin = w + w' dt .
"""
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled


class Motion(IntEnum):
    """What a ball is doing; the numbers are those of billiard_shot_msgs/msg/BallTrajectory."""

    REST = 0
    SLIDE = 1  # on the cloth, its lowest point slips
    ROLL = 2  # on the cloth, without slip
    SPIN = 3  # turns in place about the vertical
    FLIGHT = 4


REST, SLIDE, ROLL, SPIN, FLIGHT = (int(motion) for motion in Motion)

# columns of a row
TIME, MOTION = 0, 1
POSITION, VELOCITY, ACCELERATION = 2, 5, 8  # three each
ANGULAR, ANGULAR_ACCELERATION = 11, 14
COLUMNS = 17

# A ball on its way is such a row too, with one column more: the number of segments written so far.
COUNT = 17


@compiled
def start(
    position: NDArray[np.float64], velocity: NDArray[np.float64], spin: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Ball on its way from this state at time 0."""
    ball = np.zeros(COLUMNS + 1)
    for i in range(3):
        ball[POSITION + i] = position[i]
        ball[VELOCITY + i] = velocity[i]
        ball[ANGULAR + i] = spin[i]
    return ball


@compiled
def follow(ball: NDArray[np.float64], duration: float, segments: NDArray[np.float64]) -> None:
    """
    Write the ball's motion down, then move it on by `duration` [s], and clear its accelerations.

    An endless motion stays where it begins. Rows that `segments` has no room for are only counted.
    """
    count = int(ball[COUNT])
    if count < segments.shape[0]:
        for i in range(COLUMNS):
            segments[count, i] = ball[i]
    ball[COUNT] += 1.0
    for i in range(3):
        if duration < np.inf:
            change = ball[ACCELERATION + i] * duration
            ball[POSITION + i] += (ball[VELOCITY + i] + 0.5 * change) * duration
            ball[VELOCITY + i] += change
            ball[ANGULAR + i] += ball[ANGULAR_ACCELERATION + i] * duration
        ball[ACCELERATION + i] = 0.0
        ball[ANGULAR_ACCELERATION + i] = 0.0
    if duration < np.inf:
        ball[TIME] += duration
