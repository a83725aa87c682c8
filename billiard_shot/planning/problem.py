"""A planning problem as arrays: made once, then sent to the workers that evaluate strokes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import Limits
from billiard_shot.planning.strikes import Array
from billiard_shot.planning.targets import Gate, Hit, Pass, Pot, Rest, Target
from billiard_shot.scene import Noise, Scene
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.model import StrikeModel
from billiard_shot.shot.on_table import names_of
from billiard_shot.table.effects import params_on_table
from billiard_shot.table.geometry import layout_of, Table
from billiard_shot.table.params import TableParams
from billiard_shot.table.run import POCKET_NAMES


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Scene, target, limits and noise, in the form that batches of strokes need."""

    scene: Scene
    target: Target
    limits: Limits
    noise: Noise
    model: StrikeModel
    table: TableParams
    layout: Table
    names: tuple[str, ...]  # of all balls, the cue ball first
    places: Array  # (balls, 2) m
    ball: int  # index of the ball of the target, 0 for the cue ball
    first: int  # index of the ball that must be met first, 0 if any may be
    pockets: NDArray[np.int64]  # pockets into which the ball may fall
    sigmas: Array  # (5,) of a, b (ball radii), elevation, azimuth (rad), speed (m/s)

    @property
    def radius(self) -> float:
        """Radius of the balls [m]."""
        return self.model.surface.radius

    @property
    def cue_ball(self) -> Array:
        """Position of the cue ball (2,) [m]."""
        return self.places[0]

    @property
    def half_sizes(self) -> tuple[float, float]:
        """Half length and half width of the area of ball centres [m]."""
        numbers = self.layout.numbers
        return numbers.centre_half_length, numbers.centre_half_width

    def hole(self, pocket: int) -> Array:
        """Return the centre of a pocket's hole (2,) [m]."""
        hole = self.layout.pockets[pocket]
        return np.array([hole.hole_x, hole.hole_y])


def problem_of(scene: Scene, target: Target, limits: Limits, noise: Noise) -> Problem:
    """Make the planning problem of a scene and a target."""
    names = names_of(scene)
    places = np.array([scene.cue_ball[:2], *(scene.balls[name] for name in names[1:])])
    params, table = params_on_table(scene)
    ball, pockets = 0, np.empty(0, np.int64)
    match target:
        case Pot():
            ball = names.index(target.pot)
            pockets = np.array([POCKET_NAMES.index(pocket) for pocket in target.pocket])
        case Hit():
            ball = names.index(target.hit)
    first = names.index(limits.first_contact) if limits.first_contact else 0
    sigmas = np.array(
        [
            noise.a / scene.ball.radius,
            noise.b / scene.ball.radius,
            np.radians(noise.elevation_deg),
            np.radians(noise.azimuth_deg),
            noise.speed,
        ]
    )
    return Problem(
        scene,
        target,
        limits,
        noise,
        model_of(scene),
        table,
        layout_of(params, table),
        names,
        places,
        ball,
        first,
        pockets,
        sigmas,
    )


def point_of(target: Target) -> tuple[float, float] | None:
    """Return the point that the cue ball has to reach [m], None if the target has none."""
    match target:
        case Rest():
            return target.rest
        case Pass():
            return target.passing
        case Gate():
            (x, y), (u, v) = target.gate
            return 0.5 * (x + u), 0.5 * (y + v)
    return None
