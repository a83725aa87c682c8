"""How the execution of a shot ended: one enumeration for the library and the action."""

from enum import IntEnum


class Outcome(IntEnum):
    """
    Outcome of an order to play a shot.

    The numbers are part of the interface: the constants in the result of
    `billiard_shot_msgs/action/ExecuteShot` map to them one to one. Zero is success; from 100 on
    the order was refused before anything moved for it.
    """

    OK = 0
    CANCELED = 1
    DISARMED = 2  # by somebody, or with the node, or because the interlock opened
    ARM_TIMEOUT = 3  # armed for too long without being able to fire
    ESTOP = 4
    FAULT = 5  # the mechanism did not do as told
    EXPIRED = 6  # not armed in time: the order was no longer valid
    TABLE_MOVED = 7  # a ball moved between the order and the shot
    NOT_READY = 100  # not active, not disarmed, or an input does not allow it
    BUSY = 101  # another shot is being executed
    INVALID_PLAN = 102  # a field makes no sense, or contradicts another
    PLAN_CHANGED = 103  # the plan is not what was sealed, or not what this shot id stood for
    ALREADY_EXPIRED = 104
    NONCE_REPEATED = 105
    TABLE_UNKNOWN = 106  # nobody has said where the balls lie
    TABLE_DIFFERS = 107  # a ball does not lie where the plan has it
    NOT_PREDICTED = 108  # the library refuses the stroke, or does not finish it
    SPEED_OUT_OF_LIMITS = 109
    ELEVATION_OUT_OF_LIMITS = 110
    OUT_OF_REACH = 111  # a joint would be out of its range
    STROKE_OUT_OF_LIMITS = 112  # force, travel, or the brake before the cloth
    TOUCHES_AGAIN = 113  # the cue would touch the ball a second time, or another ball

    @property
    def refused(self) -> bool:
        """Whether nothing was done."""
        return self >= 100


class RefusedError(ValueError):
    """An order that is refused: its outcome, and a message that says why."""

    def __init__(self, outcome: Outcome, message: str) -> None:
        super().__init__(message)
        self.outcome = outcome
