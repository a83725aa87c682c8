"""Data of the controller: its settings, commands, results, and the goal being executed."""

from dataclasses import dataclass, field
import math

import numpy as np

from billiard_shot.cue.joint_trajectory import JointTrajectory, StrokeProfile
from billiard_shot.cue.mechanism import STROKE
from billiard_shot.cue.model import forward_kinematics, TipPose
from billiard_shot.cue.plan import GoalOutcome, PreparedShot
from billiard_shot.perception.table_watch import TableSettings
from billiard_shot.records import Array
from billiard_shot.scene.fields import number

AVERAGED_FRACTION = 0.8
"""Last fraction of the distance at constant speed, over which the speed is averaged."""


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredStrike:
    """Measured strike: the pose of the tip as it met the ball, and its speed [m/s]."""

    tip: TipPose
    speed: float


@dataclass(slots=True)
class StrikeDetector:
    """
    Detects the strike in one stroke.

    `strike` is None until the cue has met the ball, and afterwards if nothing was measured just
    before; `missing` says that.
    """

    profile: StrokeProfile
    strike: MeasuredStrike | None = None
    has_met: bool = False  # whether the cue was measured where it meets the ball, or beyond
    _speeds: list[float] = field(default_factory=list)
    _joints: Array | None = None

    @property
    def missing(self) -> str:
        """Return why a strike was not measured; '' if it was, or if there was none."""
        if self.strike or not self.has_met:
            return ''
        needed = AVERAGED_FRACTION * self.profile.mechanism.steady_time
        return (
            f'the strike was not measured: no joint_states in the last {1e3 * needed:.3g} ms '
            'before it'
        )

    def update(self, position: Array, velocity: Array) -> bool:
        """Take measured joints (6,); return whether the cue has just met the ball."""
        if self.has_met:
            return False
        contact = self.profile.contact_at
        if position[STROKE] < contact:
            if position[STROKE] >= contact - AVERAGED_FRACTION * self.profile.steady_way:
                self._speeds.append(float(velocity[STROKE]))
                self._joints = position
            return False
        self.has_met = True
        if self._joints is not None:
            mechanism, joints = self.profile.mechanism, self._joints.copy()
            joints[STROKE] = contact
            speed = mechanism.alignment.speed(float(np.mean(self._speeds)))
            self.strike = MeasuredStrike(forward_kinematics(mechanism, joints), speed)
        return True


MIN_DURATION, LATEST_STOP = 0.05, 2.0
"""Range of the time-outs that end in a stop [s]; a later stop would be too late."""


@dataclass(frozen=True, slots=True)
class Settings(TableSettings):
    """
    Time-outs and tolerances of the controller, in addition to those of the table state.

    Parameters
    ----------
    estop_timeout : float
        If `estop` is silent for longer than this, it is an emergency stop [s].
    interlock_timeout : float
        If `interlock` is silent for longer than this, it counts as open [s].
    joint_states_timeout : float
        If `joint_states` is silent for longer than this, it is a fault [s].
    arm_timeout : float
        If the cue is armed for longer than this without firing, it disarms [s].
    settle_time : float
        Time from armed to the start of the stroke; below arm_timeout [s].
    max_goal_validity : float
        Longest time for which a goal may be valid [s].
    motion_timeout : float
        Longest allowed delay behind the commanded trajectory, start-up included; beyond it the
        driver faults [s].
    aim_tolerance : float
        Largest error of the position of a joint, relative to its range.
    brake_tolerance : float
        Largest distance by which the cue may overrun its planned stop; beyond it the driver
        faults [m].

    """

    estop_timeout: float = number('s', minimum=MIN_DURATION, maximum=LATEST_STOP, default=0.5)
    interlock_timeout: float = number('s', minimum=MIN_DURATION, maximum=LATEST_STOP, default=0.5)
    joint_states_timeout: float = number(
        's', minimum=MIN_DURATION, maximum=LATEST_STOP, default=0.5
    )
    arm_timeout: float = number('s', minimum=0.1, maximum=60.0, default=5.0)
    settle_time: float = number('s', minimum=0.0, maximum=10.0, default=0.1)
    max_goal_validity: float = number('s', minimum=1.0, maximum=3600.0, default=600.0)
    motion_timeout: float = number('s', minimum=0.1, maximum=30.0, default=2.0)
    aim_tolerance: float = number('', minimum=1e-9, maximum=0.01, default=2e-4)
    brake_tolerance: float = number('m', minimum=1e-4, maximum=0.02, default=0.005)

    @property
    def max_pause(self) -> float:
        """
        Longest time between two ticks after which the inputs are still trusted [s].

        If the controller has not run for longer, all earlier messages are stale.
        """
        return 0.5 * min(self.estop_timeout, self.interlock_timeout, self.joint_states_timeout)


@dataclass(frozen=True, slots=True, eq=False)
class Command:
    """
    Command for the mechanism: follow a trajectory, or stop.

    Until the time `whole` [s] the trajectory must not be cut: it is a stroke, which brakes before
    the cloth and draws the cue back.
    """

    trajectory: JointTrajectory | None  # None: stop
    whole: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """How a goal ended; `strike` is None if the cue met no ball, or if that was not measured."""

    outcome: GoalOutcome
    message: str
    has_met: bool = False  # whether the cue met the ball
    strike: MeasuredStrike | None = None


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
