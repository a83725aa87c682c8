"""What a prediction gives back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.collide import CollisionResult, Phase, read_log
from billiard_shot.renamed import former_attributes
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, in_hand
from billiard_shot.shot.double_hit import first_double_hit
from billiard_shot.shot.effects import Effect, effects_of, effects_of_nothing, ShotContext
from billiard_shot.shot.messages import message_of
from billiard_shot.shot.sensitivity import sensitivity_of
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.run import TableRun
from billiard_shot.table.trajectory import Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class Impact:
    """
    The impact between cue, ball (contact 0) and table (contact 1).

    Where the ball touches others or a cushion, their contacts come after these.
    """

    dissipated: NDArray[np.float64]  # (N, 2) J: a row a contact: restitution, friction
    phases: tuple[Phase, ...]  # in order: the active contacts, and how it stood at the end


@former_attributes(jump='discontinuity')
@dataclass(frozen=True, eq=False)
class Shot:
    """
    A predicted shot. Numbers are in SI units and the frame `table`; arrays cannot be changed.

    If `status.refused`, the stroke was not played: the ball stays where it is.
    """

    scene: Scene
    stroke: Stroke
    tolerance: float  # m
    wall_time: float  # s that the prediction took
    trajectory: Trajectory  # of the cue ball, from the end of the strike
    table: TableRun | None  # every ball, where there is more than this one on an endless cloth
    # m, between the two resting places on endless cloth that law `energetic` allows within the
    # accuracy of the strike; 0 if there is only one
    discontinuity: float
    _strike: np.void = field(repr=False)  # Strike
    _log: NDArray[np.void] = field(repr=False)  # (phases, 2) PhaseLog
    _group: CollisionResult | None = field(repr=False)  # if the ball touched others
    _again: Callable[[Scene], Shot] = field(repr=False)  # predicts the stroke in another scene

    @property
    def status(self) -> Status:
        """How it ended; TOLERANCE_NOT_REACHED also if there is a `discontinuity`."""
        return Status(int(self._strike['status']))

    @cached_property
    def message(self) -> str:
        """The outcome in one line; for a refused stroke, what is wrong with it."""
        if self.discontinuity > 0.0:
            return (
                'law: the energetic law is discontinuous here; within the accuracy of the strike '
                f'the ball may rest at either of two positions {self.discontinuity:.2g} m apart'
            )
        outcome = message_of(self.status, self.scene, self.stroke, self.trajectory, self.table)
        if self.double_hit is None:
            return outcome
        return f'{outcome}; a double hit: the cue has the ball again at {self.double_hit:.3g} s'

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocity of the ball's centre at the end of the strike (3,) [m/s]."""
        velocity: NDArray[np.float64] = self._strike['velocity']
        return velocity

    @property
    def spin(self) -> NDArray[np.float64]:
        """Angular velocity of the ball at the end of the strike (3,) [rad/s]."""
        spin: NDArray[np.float64] = self._strike['spin']
        return spin

    @property
    def cue_speed(self) -> float:
        """Cue speed along the stroke at the end of the strike [m/s], negative if it recoils."""
        return float(self._strike['cue_speed'])

    @cached_property
    def impact(self) -> Impact:
        """The impact in detail."""
        if self._group:
            return Impact(self._group.dissipated, self._group.phases)
        phases = read_log(self._log, self._strike['axes'].reshape(2, 3, 3))
        return Impact(self._strike['losses'].reshape(2, 2), phases)

    @cached_property
    def double_hit(self) -> float | None:
        """
        When the cue would catch the ball again, following through at its speed [s]; or None.

        From the end of the strike, to 0.2 ms. Found, not simulated.
        """
        if self.status.refused or self.scene.effects.double_hit == 'off':
            return None
        direction = np.array(self.stroke.velocity) / self.stroke.speed
        normal = self._strike['axes'][:3]
        tip = self.trajectory.at(0.0).position + self.scene.ball.radius * normal
        return first_double_hit(
            self.trajectory, self.scene.ball.radius, tip, direction, self.cue_speed
        )

    @cached_property
    def effects(self) -> tuple[Effect, ...]:
        """Every effect the library knows: whether it was simulated, and why."""
        if self.status.refused:
            return effects_of_nothing()
        return effects_of(self.effect_context, lambda scene: self._again(scene).effect_context)

    @property
    def effect_context(self) -> ShotContext:
        """What the gates of effects decide by."""
        return ShotContext(
            self.scene,
            self.velocity,
            self.spin,
            self.trajectory,
            self.table,
            self._group is not None,
            self.stroke,
            self._strike['impulses'].reshape(2, 3),
            self.cue_speed,
            self.double_hit,
        )

    @property
    def error_estimate(self) -> float:
        """Estimated largest error of the trajectory [m], with the `discontinuity`."""
        return float(self._strike['error'])

    @property
    def evaluations(self) -> int:
        """Steps that the impact took."""
        return int(self._strike['steps'])

    def after(self) -> Scene:
        """
        Return the scene after the shot: the balls where they rest.

        Balls in pockets and off the table are gone. If the cue ball is, it lies at the free place
        of the head string that is nearest to the middle (`ball in hand`).
        """
        balls = dict(self.scene.balls)
        if self.table is None:
            x, y, _ = self.trajectory.final_position.tolist()
            return replace(self.scene, balls={**balls, CUE_BALL: (x, y)})
        gone = {*self.table.pocketed, *self.table.off_table}
        balls = {
            name: (float(place[0]), float(place[1]))
            for name, place in self.table.final_position.items()
            if name not in gone
        }
        if CUE_BALL in gone:
            balls[CUE_BALL] = in_hand(self.scene, balls)
        return replace(self.scene, balls=balls)

    @cached_property
    def sensitivity(self) -> NDArray[np.float64]:
        """
        How the place of rest (x, y) changes with the stroke (2, 5).

        Per radius of a and of b, radian of elevation and of azimuth, and m/s of speed: all in m.
        Zero for a refused stroke. Computed when first asked for.
        """
        if self.status.refused:
            return np.zeros((2, 5))
        return sensitivity_of(self.scene, self.stroke, self.trajectory.at(0.0).position)
