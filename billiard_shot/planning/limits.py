"""Limits of planned strokes: those of the robot, and the clearance that the cue needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.numerics.angles import wrapped
from billiard_shot.records import Array
from billiard_shot.scene import Noise, Robot, Scene
from billiard_shot.scene.checks import read
from billiard_shot.scene.errors import found_in, InputError, Mistake, must_be_one_of, unknown
from billiard_shot.scene.player import A, AZIMUTH, B, ELEVATION, SPEED
from billiard_shot.scene.values import check_type, one_or_many
from billiard_shot.shot.lowest_elevation import first_clear, Margins, margins_for

BALL_CONSTRAINTS = ('first_contact', 'keep')  # constraints that name balls
DIRECTIONS = 72  # in which the clearance of the cue is checked


@dataclass(frozen=True, slots=True)
class Limits:
    """
    Limits of planned strokes.

    Parameters
    ----------
    robot : Robot
    first_contact : tuple of str
        One of these balls must be met before any other, as the rules of many games demand; if
        empty, any ball may be met first.
    keep : tuple of str
        Balls that must not be pocketed.
    margins : Margins
        Of the clearance of the cue.

    """

    robot: Robot
    first_contact: tuple[str, ...]
    keep: tuple[str, ...]
    margins: Margins

    @property
    def elevations(self) -> tuple[float, float]:
        """Smallest and largest elevation [rad]."""
        robot = self.robot
        return math.radians(robot.elevation_min_deg), math.radians(robot.elevation_max_deg)

    def clip(self, strokes: Array) -> Array:
        """Return the nearest strokes (n, 5) within the robot's limits."""
        robot, clipped = self.robot, strokes.copy()
        offset = np.hypot(clipped[:, A], clipped[:, B])
        clipped[:, :2] *= np.minimum(1.0, robot.offset_max / np.maximum(offset, 1e-12))[:, None]
        clipped[:, ELEVATION] = np.clip(clipped[:, ELEVATION], *self.elevations)
        clipped[:, SPEED] = np.clip(clipped[:, SPEED], robot.speed_min, robot.speed_max)
        middle = math.radians(robot.azimuth_deg)
        half_range = math.radians(robot.azimuth_half_range_deg)
        turn = wrapped(clipped[:, AZIMUTH] - middle)
        if half_range < np.pi:
            turn = np.clip(turn, -half_range, half_range)
        clipped[:, AZIMUTH] = wrapped(middle + turn)
        return clipped

    def allows_azimuth(self, azimuths: Array) -> NDArray[np.bool_]:
        """Whether the robot can strike in these directions."""
        away = np.abs(wrapped(azimuths - math.radians(self.robot.azimuth_deg)))
        half_range = math.radians(self.robot.azimuth_half_range_deg)
        allowed: NDArray[np.bool_] = away <= half_range + 1e-12
        return allowed


def limits_of(scene: Scene, constraints: Mapping[str, Any] | Robot | None, noise: Noise) -> Limits:
    """
    Read constraints; the scene's section `robot` supplies those that are missing.

    Raises
    ------
    ValueError
        Naming every wrong field.

    """
    margins = margins_for(noise, scene.ball.radius)
    given = scene.robot if constraints is None else constraints
    if isinstance(given, Robot):
        return Limits(given, (), (), margins)
    check_type('constraints', given, Mapping)
    data = dict(given)
    mistakes: list[Mistake] = []
    chosen = {key: _names(scene, key, data.pop(key, None), mistakes) for key in BALL_CONSTRAINTS}
    robot, known = scene.robot, asdict(scene.robot)
    for key in data:
        if key not in known:
            mistakes.append(Mistake((str(key),), unknown(str(key), [*known, *BALL_CONSTRAINTS])))
    try:
        robot = read(Robot, {**known, **{key: data[key] for key in data if key in known}})
    except InputError as error:
        mistakes += found_in(error)
    if mistakes:
        raise InputError(mistakes, 'constraints')
    return Limits(robot, chosen['first_contact'], chosen['keep'], margins)


def _names(scene: Scene, key: str, value: Any, mistakes: list[Mistake]) -> tuple[str, ...]:
    """Read the name of a ball, or several names; add the unknown ones to the mistakes."""
    names = () if value is None else one_or_many(value)
    for name in names:
        if str(name) not in scene.object_balls:
            mistakes.append(Mistake((key,), must_be_one_of(scene.object_balls, name, 'ball')))
    return tuple(map(str, names))


def raise_for_clearance(scene: Scene, limits: Limits, strokes: Array) -> Array:
    """
    Raise the cue of strokes (n, 5) until it clears balls, cushions and cloth.

    Strokes with enough clearance are not changed. Strokes without clearance within the limits
    become NaN.
    """
    lowest, highest = limits.elevations
    # with errors, a level cue may point up
    first = max(lowest, min(limits.margins.elevation, highest))
    low = np.maximum(strokes[:, ELEVATION], first)
    found = strokes.copy()
    found[:, ELEVATION] = first_clear(scene, strokes, low, highest, limits.margins)
    found[np.isnan(found[:, ELEVATION])] = np.nan
    return found


def check_clearance(scene: Scene, limits: Limits) -> None:
    """Raise ValueError if the cue has no clearance for any stroke at the centre of the ball."""
    robot = limits.robot
    strokes = np.zeros((DIRECTIONS, 5))
    half_range = math.radians(robot.azimuth_half_range_deg)
    turns = np.linspace(-half_range, half_range, DIRECTIONS)
    strokes[:, AZIMUTH] = math.radians(robot.azimuth_deg) + turns
    strokes[:, SPEED] = robot.speed_min
    free = replace(limits, robot=replace(robot, elevation_max_deg=90.0))
    needed = raise_for_clearance(scene, free, strokes)[:, ELEVATION]
    if np.isnan(needed).all():
        raise ValueError(
            'constraints: azimuth_deg, azimuth_half_range_deg must allow a direction in which the '
            f'cue has clearance, got {robot.azimuth_deg:g} and {robot.azimuth_half_range_deg:g} '
            '(degrees)'
        )
    if np.nanmin(needed) > limits.elevations[1]:
        raise ValueError(
            'constraints: elevation_max_deg must be at least '
            f'{math.degrees(np.nanmin(needed)):.3g} beside the obstacles around the cue ball and '
            f'with the errors of strokes, got {robot.elevation_max_deg:g} (degrees)'
        )
