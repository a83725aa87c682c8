"""A strike as equations in contact space, which every method and law of the studies solves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from billiard_shot.impact.collide import (
    contact_space,
    ContactSpace,
    System,
    system_of,
    velocity_changes,
)
from billiard_shot.impact.kernel import Properties, solve_in_contact_space
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.shot.effects import strike_model, StrikeModel
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.run.results import BallState
from billiard_shot.table.run.simulate import simulate
from studies.collisions import collision_of

BOUNCE_TOLERANCE = 1e-13  # m, for leaving out bounces
Answer = tuple[Array, Array, int]  # ball velocity (m/s), spin (rad/s), evaluations


@dataclass(frozen=True, slots=True)
class ContactProblem:
    """
    A strike in contact space: u = velocity + response J.

    Attributes
    ----------
    system : System
        Cue, ball and table.
    space : ContactSpace
        Tip and table, each normal and two tangential components.
    friction, restitution, stiffness : (2,) float arrays
    law : str

    """

    scene: Scene
    stroke: Stroke
    model: StrikeModel
    system: System
    space: ContactSpace
    friction: Array
    restitution: Array
    stiffness: Array
    law: str

    @classmethod
    def of(cls, scene: Scene, stroke: Stroke) -> ContactProblem:
        """State a stroke that can be played."""
        model = strike_model(scene)
        collision = collision_of(model, np.array(stroke.normal), np.array(stroke.velocity))
        system = system_of(collision.bodies, collision.contacts)
        return cls(
            scene,
            stroke,
            model,
            system,
            contact_space(system),
            np.array(model.friction),
            np.array(model.restitution),
            np.array(model.stiffness),
            scene.law,
        )

    @property
    def response(self) -> Array:
        """W (6, 6) [1/kg]."""
        return self.space.delassus

    @property
    def velocity(self) -> Array:
        """Contact velocities before the strike (6,) [m/s]."""
        return self.space.approach

    @property
    def properties(self) -> Properties:
        """What the solver takes of the contacts."""
        model = self.model
        return Properties(
            self.friction,
            self.restitution,
            self.stiffness,
            model.law,
            np.array(model.exponent),
        )

    @property
    def speed(self) -> float:
        """Approach speed along the tip's normal [m/s]."""
        return -float(self.velocity[0])

    def motion(self, impulse: Array) -> tuple[Array, Array, float]:
        """Ball velocity [m/s], spin [rad/s] and cue speed [m/s] after impulses (6,) [N s]."""
        along = np.einsum('ik,ikl->il', impulse.reshape(2, 3), self.space.axes)
        cue, ball, _ = velocity_changes(self.system, along)
        change = float(cue[:3] @ self.stroke.velocity) / self.stroke.speed
        return ball[:3], ball[3:], self.stroke.speed + change

    def adaptive(self, tolerance: float) -> tuple[Array, int, Status]:
        """Impulses (6,) [N s] by the library's own method, its steps, and how it ended."""
        solved = solve_in_contact_space(
            self.properties,
            self.response[np.newaxis],
            self.velocity[np.newaxis],
            [tolerance],
        )
        outcome = solved.outcomes[0]
        return (
            solved.contacts['impulse'].ravel(),
            int(outcome['steps']),
            Status(outcome['status']),
        )

    def resting_place(self, velocity: Array, spin: Array) -> Array:
        """Return the place (3,) [m] at which a ball from (0, 0, r) rests on an endless cloth."""
        start = np.array([0.0, 0.0, self.scene.ball.radius])
        ball = BallState(position=start, velocity=velocity, spin=spin)
        run = simulate(replace(self.scene, table=None), {'cue': ball}, tolerance=BOUNCE_TOLERANCE)
        return run.final_position['cue']
