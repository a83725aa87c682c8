"""A stroke as equations, which every method of the accuracy study solves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billiard_shot.impact.solve import solve_in_contact_space
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.shot.contacts import in_contact_space, tip_response
from billiard_shot.shot.model import contact_properties, strike_model, StrikeModel
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status

Answer = tuple[Array, Array, int]  # ball velocity (m/s), spin (rad/s), evaluations


@dataclass(frozen=True, slots=True)
class ContactProblem:
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
    model: StrikeModel
    response: Array
    velocity: Array
    friction: Array
    restitution: Array
    stiffness: Array
    law: str

    @classmethod
    def of(cls, scene: Scene, stroke: Stroke) -> ContactProblem:
        """State a stroke that can be played."""
        model = strike_model(scene)
        n, c, speed = np.array(stroke.normal), np.array(stroke.velocity), stroke.speed
        _, response, velocity = in_contact_space(model, n, c / speed, speed)
        return cls(
            scene,
            stroke,
            model,
            response,
            velocity,
            np.array(model.friction),
            np.array(model.restitution),
            np.array(model.stiffness),
            scene.law,
        )

    @property
    def speed(self) -> float:
        """Approach speed along the tip's normal [m/s]."""
        return -float(self.velocity[0])

    def motion(self, impulse: Array) -> tuple[Array, Array, float]:
        """Ball velocity [m/s], spin [rad/s] and cue speed [m/s] after these impulses."""
        ball, n = self.model.surface, np.array(self.stroke.normal)
        c = np.array(self.stroke.velocity) / self.stroke.speed
        lever, _, _ = in_contact_space(self.model, n, c, self.stroke.speed)
        cue = tip_response(self.model, c, impulse @ lever[0], c)
        velocity, turning = impulse @ lever[1], impulse @ lever[2]
        return velocity / ball.mass, turning / ball.inertia, self.stroke.speed + cue

    def adaptive(self, tolerance: float) -> tuple[Array, int, Status]:
        """Impulses (6,) [N s] by the library's own method, its steps, and how it ended."""
        solved = solve_in_contact_space(
            contact_properties(self.model),
            self.response[np.newaxis],
            self.velocity[np.newaxis],
            [tolerance],
        )
        return solved.impulses.ravel(), int(solved.steps[0]), Status(solved.status[0])
