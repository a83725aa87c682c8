"""Measurement of a stroke by the encoders: when, where and how fast the cue met the ball."""

from dataclasses import dataclass, field

import numpy as np

from billiard_shot.cue.kinematics import forward_kinematics, TipPose
from billiard_shot.cue.mechanism import STROKE
from billiard_shot.cue.profile import StrokeProfile
from billiard_shot.records import Array

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
    before.
    """

    profile: StrokeProfile
    strike: MeasuredStrike | None = None
    has_met: bool = False  # whether the cue was measured where it meets the ball, or beyond
    _speeds: list[float] = field(default_factory=list)
    _joints: Array | None = None

    @property
    def problem(self) -> str:
        """Return why there is no strike; '' if there is one."""
        if self.strike:
            return ''
        if not self.has_met:
            return 'the cue has not met the ball'
        needed = AVERAGED_FRACTION * self.profile.mechanism.steady_time
        return (
            f'the strike was not measured: no joint_states in the last {1e3 * needed:.3g} ms '
            'before it'
        )

    def update(self, position: Array, velocity: Array) -> MeasuredStrike | None:
        """Take measured joints (6,); return the strike if the cue has just met the ball."""
        if self.has_met:
            return None
        contact = self.profile.contact_at
        if position[STROKE] < contact:
            if position[STROKE] >= contact - AVERAGED_FRACTION * self.profile.steady_way:
                self._speeds.append(float(velocity[STROKE]))
                self._joints = position
            return None
        self.has_met = True
        if self._joints is None:
            return None
        joints = self._joints.copy()
        joints[STROKE] = contact
        speed = float(np.mean(self._speeds))
        self.strike = MeasuredStrike(forward_kinematics(self.profile.mechanism, joints), speed)
        return self.strike
