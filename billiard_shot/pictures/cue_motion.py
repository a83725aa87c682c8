"""The cue before, during and after a strike, as pages and videos show it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from billiard_shot.pictures.trails import Trails
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.shot import Shot

SWING = 0.3  # m, largest distance over which the cue is accelerated
MAX_ACCELERATION_TIME = 0.8  # s, largest duration of the acceleration


@dataclass(frozen=True, slots=True, eq=False)
class CueMotion:
    """
    Motion of the cue along its axis; the strike is at time 0.

    Attributes
    ----------
    tip : (3,) float array
        Point where the tip meets the ball [m], frame `table`.
    direction : (3,) float array
        Direction of the motion; a unit vector, frame `table`.
    swing : float
        Distance over which the cue is accelerated evenly [m].
    time : float
        Time that this takes [s].
    after : float
        Speed just after the strike [m/s].

    """

    tip: NDArray[np.float64]
    direction: NDArray[np.float64]
    swing: float
    time: float
    after: float

    def way(self, time: float) -> NDArray[np.float64]:
        """Displacement of the cue from its position at the strike (3,) [m]."""
        if time >= 0.0:
            return self.after * time * self.direction
        begun = max(1.0 + time / self.time, 0.0)
        return -self.swing * (1.0 - begun * begun) * self.direction


def cue_motion(shot: Shot, trails: Trails) -> CueMotion:
    """Choose how the cue of a shot moves: the shot has only its speeds at the strike."""
    radius = shot.scene.ball.radius
    stroke = shot.stroke.touching(shot.scene.cue.tip_curvature_radius / radius)
    swing = min(SWING, 0.5 * stroke.speed * MAX_ACCELERATION_TIME)
    return CueMotion(
        tip=trails.start(CUE_BALL) + radius * np.array(stroke.normal),
        direction=np.array(stroke.velocity) / stroke.speed,
        swing=swing,
        time=2.0 * swing / stroke.speed,
        after=0.0 if shot.status.refused else shot.cue_speed,
    )
