"""A planning problem as arrays: made once, then sent to the workers that evaluate strokes."""

from __future__ import annotations

from dataclasses import dataclass
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import Limits
from billiard_shot.planning.score import Goal, Kind
from billiard_shot.planning.targets import (
    ANY,
    Break,
    Gate,
    Hit,
    met_first,
    Pass,
    Pot,
    Rest,
    Safe,
    Target,
)
from billiard_shot.records import Array, ROWS
from billiard_shot.scene import Noise, Scene
from billiard_shot.shot.setting import Setting, setting_of
from billiard_shot.shot.strike_model import StrikeModel
from billiard_shot.table.geometry import layout_of, POCKETS
from billiard_shot.table.run import POCKET_NAMES
from billiard_shot.table.simulation_state import BallRule


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """Scene, target and limits, in the form that batches of strokes need."""

    scene: Scene
    target: Target
    limits: Limits
    noise: Noise
    setting: Setting
    half_sizes: tuple[float, float]  # m, of the area of ball centres, along and across
    places: Array  # (balls, 2) m
    balls: tuple[int, ...]  # indices of the balls to be potted, or of those to be met first
    pockets: NDArray[np.int64]  # pockets into which the balls may fall
    goal: NDArray[np.void]  # (1,) Goal
    rules: NDArray[np.void]  # (balls,) BallRule; none is `sought`
    wanted: Array  # (balls, POCKETS) above 0 if the ball may fall into the pocket
    holes: Array  # (POCKETS, 2) m
    sigmas: Array  # (5,) of a, b (ball radii), elevation, azimuth (rad), speed (m/s)

    @property
    def model(self) -> StrikeModel:
        """The numbers that a strike depends on."""
        return self.setting.model

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all balls, the cue ball first."""
        return self.setting.names

    @property
    def radius(self) -> float:
        """Radius of the balls [m]."""
        return self.model.surface.radius

    @property
    def cue_ball(self) -> Array:
        """Position of the cue ball (2,) [m]."""
        return self.places[0]

    def may_meet(self, ball: int) -> bool:
        """Whether the cue ball may meet a ball before any other."""
        return not self.rules['barred'][ball]


def problem_of(scene: Scene, target: Target, limits: Limits, noise: Noise) -> Problem:
    """Make the planning problem of a scene and a target."""
    setting = setting_of(scene)
    names, places = setting.names, setting.starts['position'][0, :, :2].copy()
    layout = layout_of(setting.model.surface, setting.table)
    rules: NDArray[np.void] = ROWS.records(BallRule, len(names))
    rules['must_stay'] = [name == names[0] or name in limits.keep for name in names]
    if limits.first_contact:
        rules['barred'] = [name not in limits.first_contact for name in names]
    balls: tuple[int, ...] = ()
    pockets = np.empty(0, np.int64)
    wanted = np.zeros((len(names), POCKETS))
    match target:
        case Pot():
            free = np.flatnonzero(~rules['must_stay']).tolist()
            balls = tuple(i for i in free if target.wants(names[i]))
            pockets = np.array([POCKET_NAMES.index(pocket) for pocket in target.pocket])
            for i in balls:
                wanted[i, pockets] = 1.0
        case Hit() | Safe() | Break():
            first = met_first(target)
            balls = tuple(i for i in range(1, len(names)) if ANY in first or names[i] in first)
            if not isinstance(target, Hit):
                rules['barred'][[i for i in range(len(names)) if i not in balls]] = True
    holes = np.zeros((POCKETS, 2))
    if layout.pockets:
        holes[:] = [(hole.hole_x, hole.hole_y) for hole in layout.pockets]
    return Problem(
        scene,
        target,
        limits,
        noise,
        setting,
        (layout.numbers.centre_half_length, layout.numbers.centre_half_width),
        places=places,
        balls=balls,
        pockets=pockets,
        goal=_goal(target, scene.ball.radius, balls, must_meet=bool(limits.first_contact)),
        rules=rules,
        wanted=wanted,
        holes=holes,
        sigmas=noise.sigmas(scene.ball.radius),
    )


def _goal(
    target: Target, radius: float, balls: tuple[int, ...], *, must_meet: bool
) -> NDArray[np.void]:
    """Write a target as numbers."""
    goals: NDArray[np.void] = ROWS.records(Goal, 1)
    goal: Any = goals[0]
    goal.ball_radius = radius
    goal.must_meet = must_meet or isinstance(target, Safe | Break)
    match target:
        case Rest():
            goal.kind, (goal.x, goal.y), goal.radius = Kind.REST, target.rest, target.radius
        case Pass():
            goal.kind, (goal.x, goal.y), goal.radius = Kind.PASS, target.passing, target.radius
        case Gate():
            goal.kind, ((goal.x, goal.y), (goal.u, goal.v)) = Kind.GATE, target.gate
        case Hit():
            goal.kind, goal.ball = Kind.HIT, balls[0]
            if target.direction is not None:
                goal.kind, (goal.x, goal.y) = Kind.HIT_DIRECTION, target.direction
                goal.radius = math.radians(target.direction_tolerance_deg)
            elif target.at is not None:
                goal.kind, (goal.x, goal.y) = Kind.HIT_AT, target.at
                goal.radius = target.radius
        case Pot():
            goal.kind = Kind.POT
            if target.leave is not None:
                goal.kind, (goal.x, goal.y) = Kind.POT_AND_LEAVE, target.leave
                goal.radius = target.radius
        case _:
            goal.kind = Kind.FOULS
    return goals


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
