"""Data of the controller: its settings, commands and results, and the goal being executed."""

from dataclasses import dataclass
import math

from billiard_shot.cue.joint_trajectory import JointTrajectory
from billiard_shot.cue.measurement import Strike, StrikeDetector
from billiard_shot.cue.outcome import Outcome
from billiard_shot.cue.plan import PreparedShot


@dataclass(frozen=True, slots=True)
class Settings:
    """
    Time-outs and tolerances of the controller.

    Parameters
    ----------
    estop_timeout, interlock_timeout, joint_states_timeout : float
        Longest silence of these inputs before the mechanism is stopped [s]. If the controller
        does not run for half of the shortest of these times, all earlier messages are stale.
    arm_timeout : float
        Time armed without firing after which the cue disarms [s].
    settle_time : float
        Time from armed to the start of the stroke [s].
    max_goal_validity : float
        Longest time for which a goal may be valid [s].
    motion_timeout : float
        Longest delay of the mechanism behind the end of the commanded trajectory [s].
    aim_tolerance : float
        Largest error of each joint, relative to its range.
    brake_tolerance : float
        Largest distance by which the stroke may overrun its planned end [m].
    table_timeout : float
        Longest time since a message about the balls and, before aiming, since the last detection
        of each ball [s].
    unseen_timeout : float
        Longest time since the last detection of each ball while a shot is aimed [s].
    stamp_tolerance : float
        Largest lead of the time of a detection ahead of the clock [s].
    table_tolerance : float
        Largest distance of a ball from its planned place [m].

    """

    estop_timeout: float = 0.5
    interlock_timeout: float = 0.5
    joint_states_timeout: float = 0.5
    arm_timeout: float = 5.0
    settle_time: float = 0.1
    max_goal_validity: float = 600.0
    motion_timeout: float = 2.0
    aim_tolerance: float = 2e-4
    brake_tolerance: float = 0.005
    table_timeout: float = 1.0
    unseen_timeout: float = 10.0
    stamp_tolerance: float = 0.1
    table_tolerance: float = 0.001

    @property
    def max_pause(self) -> float:
        """Longest time between two ticks after which the inputs are still trusted [s]."""
        return 0.5 * min(self.estop_timeout, self.interlock_timeout, self.joint_states_timeout)


@dataclass(frozen=True, slots=True, eq=False)
class Command:
    """
    Command for the mechanism: follow a trajectory, or stop.

    Every new command has the next `number`; a repeated command keeps its number. Until the time
    `whole` [s] the trajectory must not be cut: it is a stroke, which brakes before the cloth and
    draws the cue back.
    """

    number: int
    trajectory: JointTrajectory | None  # None: stop
    whole: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """How a goal ended; `strike` is the measured strike, None if the cue did not meet the ball."""

    outcome: Outcome
    message: str
    strike: Strike | None


@dataclass(slots=True, eq=False)
class Execution:
    """
    A goal that is being executed.

    Times are those of the controller's clock, but `expiry` is that of the clock of goals [s].
    """

    shot: PreparedShot
    expires: float
    expiry: float
    detector: StrikeDetector
    armed_until: float = -math.inf
    fire_at: float = math.inf

    def has_expired(self, now: float, time: float) -> bool:
        """Whether the goal has expired, at the times [s] of both clocks."""
        return now > self.expires or time > self.expiry
