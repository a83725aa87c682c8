"""All that a search needs to play strokes and to judge them: made once, and sent to workers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import Limits
from billiard_shot.planning.strikes import Rows
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
    """A scene, a target, limits and noise, in the form that batches of strokes take."""

    scene: Scene
    target: Target
    limits: Limits
    noise: Noise
    model: StrikeModel
    table: TableParams
    layout: Table
    names: tuple[str, ...]  # of all balls, the cue ball first
    places: Rows  # (balls, 2) m
    ball: int  # index of the ball that the target is about, 0: the cue ball itself
    first: int  # index of the ball that has to be met first, 0: any
    pockets: NDArray[np.int64]  # those in which the ball may fall
    sigmas: Rows  # (5,) of a, b (ball radii), elevation, azimuth (rad), speed (m/s)

    @property
    def radius(self) -> float:
        """Of a ball [m]."""
        return self.model.surface.radius

    @property
    def cue_ball(self) -> Rows:
        """Where the cue ball lies (2,) [m]."""
        return self.places[0]

    @property
    def half_sizes(self) -> tuple[float, float]:
        """Half length and half width of where the centre of a lying ball can be [m]."""
        numbers = self.layout.numbers
        return numbers.centre_half_length, numbers.centre_half_width

    def hole(self, pocket: int) -> Rows:
        """Find the centre of a pocket's hole (2,) [m]."""
        hole = self.layout.pockets[pocket]
        return np.array([hole.hole_x, hole.hole_y])


def problem_of(scene: Scene, target: Target, limits: Limits, noise: Noise) -> Problem:
    """Collect all that."""
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
    """Point that the cue ball has to come to, None if there is none [m]."""
    match target:
        case Rest():
            return target.rest
        case Pass():
            return target.passing
        case Gate():
            (x, y), (u, v) = target.gate
            return 0.5 * (x + u), 0.5 * (y + v)
    return None
