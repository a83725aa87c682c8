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


@compiled
def start(position: NDArray[np.float64], velocity: NDArray[np.float64],
          spin: NDArray[np.float64]) -> NDArray[np.float64]:
    """Row of a ball in this state at time 0, without accelerations."""
    row = np.zeros(COLUMNS)
    row[POSITION:VELOCITY] = position
    row[VELOCITY:ACCELERATION] = velocity
    row[ANGULAR:ANGULAR_ACCELERATION] = spin
    return row


@compiled
def follow(
    row: NDArray[np.float64], motion: int, duration: float,
    segments: NDArray[np.float64], count: int,
) -> int:
    """
    Write the motion in `row` down, then move the row on by `duration` [s]; return the new count.

    An endless motion stays where it begins. Rows that `segments` has no room for are only counted.
    """
    row[MOTION] = motion
    if count < segments.shape[0]:
        segments[count] = row
    if duration < np.inf:
        row[TIME] += duration
        for i in range(3):
            change = row[ACCELERATION + i] * duration
            row[POSITION + i] += (row[VELOCITY + i] + 0.5 * change) * duration
            row[VELOCITY + i] += change
            row[ANGULAR + i] += row[ANGULAR_ACCELERATION + i] * duration
    row[ACCELERATION:ANGULAR] = 0.0
    row[ANGULAR_ACCELERATION:] = 0.0
    return count + 1
