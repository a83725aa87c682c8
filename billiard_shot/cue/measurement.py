"""What the encoders say of a stroke: when the cue met the ball, how fast, and from where."""

from dataclasses import dataclass, field

import numpy as np

from billiard_shot.cue.mechanism import Mechanism, STROKE
from billiard_shot.cue.path import Array
from billiard_shot.cue.placing import tip_of, TipPose
from billiard_shot.cue.profile import StrokeProfile

STEADY = 0.8
"""Part of the way at steady speed, the last one, over which the speed is averaged."""


@dataclass(frozen=True, slots=True, eq=False)
class Strike:
    """The measured strike: the tip as it met the ball, and its speed along the stroke [m/s]."""

    shot_id: str
    tip: TipPose
    speed: float


@dataclass(slots=True)
class StrokeWatch:
    """Watches one stroke; `strike` is None until the cue has come to the ball."""

    mechanism: Mechanism
    profile: StrokeProfile
    shot_id: str
    strike: Strike | None = None
    _speeds: list[float] = field(default_factory=list)
    _joints: Array | None = None

    def see(self, position: Array, velocity: Array) -> bool:
        """Take note of measured joints (6,); True if the cue has just met the ball."""
        if self.strike is not None:
            return False
        contact = self.profile.contact_at
        if position[STROKE] < contact:
            steady = STEADY * self.profile.speed * self.profile.steady_time
            if position[STROKE] >= contact - steady:
                self._speeds.append(float(velocity[STROKE]))
                self._joints = position
            return False
        if self._joints is None:
            return False
        joints = self._joints.copy()
        joints[STROKE] = contact
        self.strike = Strike(
            self.shot_id, tip_of(self.mechanism, joints), float(np.mean(self._speeds))
        )
        return True
