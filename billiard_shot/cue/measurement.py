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
