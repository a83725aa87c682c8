"""How the execution of a shot ended: one enumeration for the library and the action."""

from enum import IntEnum


class GoalOutcome(IntEnum):
    """
    Outcome of a goal to play a shot.

    The numbers are part of the interface: the constants in the result of
    `billiard_shot_msgs/action/ExecuteShot` map to them one to one. Zero is success. From 100 on
    the goal was refused, and nothing moved.
    """

    OK = 0
    CANCELED = 1
    DISARMED = 2  # by a call, deactivation or the interlock, or after a pause
    ARM_TIMEOUT = 3  # armed for too long without being able to fire
    ESTOP = 4
    FAULT = 5  # the mechanism did not follow its commands
    EXPIRED = 6  # not armed in time: the goal was no longer valid
    TABLE_MOVED = 7  # a ball moved between the goal and the shot
    TABLE_STALE = 8  # the balls are no longer known well enough
    NOT_READY = 100  # not active, not disarmed, or an input does not allow it
    BUSY = 101  # another shot is being executed
    INVALID_PLAN = 102  # a field is invalid, or contradicts another field
    ALREADY_PLAYED = 103  # the cue has been aimed for this shot before
    ALREADY_EXPIRED = 104  # or the plan is from before the start of this program
    TABLE_UNKNOWN = 105  # the balls are not known well enough: too old, invalid or uncertain
    TABLE_DIFFERS = 106  # a ball does not lie at its planned place
    NOT_PREDICTED = 107  # the library refuses the stroke, or its prediction did not finish
    SPEED_OUT_OF_LIMITS = 108
    ELEVATION_OUT_OF_LIMITS = 109
    OUT_OF_REACH = 110  # a joint would be out of its range
    STROKE_OUT_OF_LIMITS = 111  # force, travel, cushions, or braking distance before the cloth
    TOUCHES_AGAIN = 112  # the cue would touch the ball a second time, or another ball
    MISCUE = 113  # the tip would slide on the ball, and the goal does not allow that

    @property
    def refused(self) -> bool:
        """Whether the goal was refused, so that nothing moved."""
        return self >= 100


class RefusedError(ValueError):
    """Refusal of a goal, with its outcome and a message that says why."""

    def __init__(self, outcome: GoalOutcome, message: str) -> None:
        super().__init__(message)
        self.outcome = outcome
