"""Outcome of a computation: one enumeration for library, command line and ROS interfaces."""

from enum import IntEnum


class Status(IntEnum):
    """
    Outcome of a collision, a shot or a simulation.

    The numbers are part of the interface: the constants in the response of
    `billiard_shot_msgs/srv/PredictShot` map to them one to one. Zero is success; from 100 on the
    request itself was refused. 1 is not used.
    """

    OK = 0
    INFINITE_SEQUENCE = 2  # an infinite, decaying sequence of impacts was replaced by its limit
    NEGATIVE_ENERGY = 3  # law `poisson` drove an elastic energy below zero
    NEVER_RESTS = 4  # nothing on this cloth brings the ball to rest
    TOLERANCE_NOT_REACHED = 5  # the result is the best available; see its error estimate
    BUDGET_EXCEEDED = 6  # too many states or steps
    OFF_TABLE = 7
    NO_PLAN = 8  # no stroke was found that reaches the target
    CANCELLED = 9  # ended on request; the result is the best so far
    MISS = 100  # the cue does not meet the ball
    NEGATIVE_ELEVATION = 101  # the stroke points up
    CUE_THROUGH_CLOTH = 102  # the cue would have to pass through the cloth
    INVALID_STROKE = 103  # a direction, point or speed that is zero, negative or not finite
    INVALID_REQUEST = 104  # any other field of a request
    CUE_THROUGH_BALL = 105  # the cue would have to pass through another ball
    CUE_THROUGH_CUSHION = 106  # the cue would have to pass through a cushion

    @property
    def refused(self) -> bool:
        """Whether nothing was computed, because the request could not be met."""
        return self >= 100


# Compiled code uses integers instead of enumerations. Comparisons with arrays do so, too: for a
# member, NumPy asks the enumeration for methods of arrays, which runs Python up to version 3.11,
# and a Ctrl+C that comes meanwhile is lost with the error that NumPy expects.
OK = int(Status.OK)
INFINITE_SEQUENCE = int(Status.INFINITE_SEQUENCE)
NEGATIVE_ENERGY = int(Status.NEGATIVE_ENERGY)
NEVER_RESTS = int(Status.NEVER_RESTS)
TOLERANCE_NOT_REACHED = int(Status.TOLERANCE_NOT_REACHED)
BUDGET_EXCEEDED = int(Status.BUDGET_EXCEEDED)
OFF_TABLE = int(Status.OFF_TABLE)
MISS = int(Status.MISS)
NEGATIVE_ELEVATION = int(Status.NEGATIVE_ELEVATION)
CUE_THROUGH_CLOTH = int(Status.CUE_THROUGH_CLOTH)
INVALID_STROKE = int(Status.INVALID_STROKE)
INVALID_REQUEST = int(Status.INVALID_REQUEST)
CUE_THROUGH_BALL = int(Status.CUE_THROUGH_BALL)
CUE_THROUGH_CUSHION = int(Status.CUE_THROUGH_CUSHION)
