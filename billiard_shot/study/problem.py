"""A stroke as equations: what every method of the accuracy study solves."""
from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.kernel import solve
from billiard_shot.scene import Scene
from billiard_shot.shot.contacts import approach_of, levers, response_of, yielding
from billiard_shot.shot.model import Model, numbers_of
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Problem:
    """
    A strike in contact space: u = velocity + response J.

    Attributes
    ----------
    response : (6, 6) float array
        W [1/kg]; tip and table, each normal and two tangential components.
    velocity : (6,) float array
        Contact velocities before the strike [m/s].
    friction, restitution, stiffness : (2,) float arrays
    law : str

    """

    scene: Scene
    stroke: Stroke
    model: Model
    response: Vector
    velocity: Vector
    friction: Vector
    restitution: Vector
    stiffness: Vector
    law: str

    @classmethod
    def of(cls, scene: Scene, stroke: Stroke) -> Problem:
        """State a stroke that can be played."""
        model = numbers_of(scene)
        n, c, speed = np.array(stroke.normal), np.array(stroke.velocity), stroke.speed
        lever = levers(model.surface.radius, n, c / speed)
        return cls(
            scene, stroke, model, response_of(model, c / speed, lever),
            approach_of(lever, speed, n, c / speed), model.friction, model.restitution,
            model.stiffness, scene.law,
        )

    @property
    def speed(self) -> float:
        """Approach speed along the tip's normal [m/s]."""
        return -float(self.velocity[0])

    def motion(self, impulse: Vector) -> tuple[Vector, Vector, float]:
        """Ball velocity [m/s], spin [rad/s] and cue speed [m/s] after these impulses."""
        ball, n = self.model.surface, np.array(self.stroke.normal)
        c = np.array(self.stroke.velocity) / self.stroke.speed
        lever = levers(ball.radius, n, c)
        cue = yielding(self.model, c, impulse @ lever[0], c)
        velocity, turning = impulse @ lever[1], impulse @ lever[2]
        return velocity / ball.mass, turning / ball.inertia, self.stroke.speed + cue

    def adaptive(self, tolerance: float) -> tuple[Vector, int, Status]:
        """Impulses (6,) [N s] by the library's own method, its steps, and how it ended."""
        impulse, account, log = np.zeros(6), np.zeros((2, 4)), np.zeros((0, 12))
        status, _, steps = solve(
            self.response, self.velocity, self.friction, self.restitution, self.stiffness,
            self.model.law, self.model.exponent, tolerance, impulse, account, log,
        )
        return impulse, steps, Status(status)
