"""What the gates of a strike decide by."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.effects import EffectContext


@dataclass(frozen=True, slots=True)
class ShotContext(EffectContext):
    """Scene, stroke and the motion that came of them."""

    stroke: Stroke
    impulses: NDArray[np.float64]  # (2, 2) N s: of tip and table; normal and tangential
    cue_speed: float  # m/s along the stroke, at the end of the strike
    double_hit: float | None  # s, when the cue hits the ball again
    chatter: bool  # the tip touched the ball again, too soon for a second hit

    def impulse(self, contact: int) -> NDArray[np.float64]:
        """Return the normal and the tangential impulse of a contact in the strike (2,) [N s]."""
        return self.impulses[contact]
