"""What strokes may be planned: the robot's limits, and those that the table sets to the cue."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.strikes import Rows, vectors_of
from billiard_shot.scene import Noise, Robot, Scene
from billiard_shot.scene.checks import read
from billiard_shot.scene.mistakes import found_in, InputError, Mistake, unknown
from billiard_shot.shot.refusals import refusals_in
from billiard_shot.status import Status

A, B, ELEVATION, AZIMUTH, SPEED = range(5)  # columns of strokes
# A planned cue stays so many standard deviations of its errors above what it must not touch.
MARGIN = 3.5
NO_ROOM = Status.CUE_THROUGH_BALL, Status.CUE_THROUGH_CUSHION
DIRECTIONS = 72  # in which room for the cue is looked for
COARSE, FINE = math.radians(4.0), math.radians(0.25)  # steps in which elevations are tried


@dataclass(frozen=True, slots=True)
class Limits:
    """
    What a planned stroke must keep to.

    Parameters
    ----------
    robot : Robot
    first_contact : str, optional
        The ball that the cue ball must meet before any other: the rule of many games.
    spare : float
        Elevation that a stroke has to have above what its surroundings ask for [rad].

    """

    robot: Robot
    first_contact: str | None
    spare: float

    @property
    def elevations(self) -> tuple[float, float]:
        """Least and largest elevation [rad]."""
        robot = self.robot
        return math.radians(robot.elevation_min_deg), math.radians(robot.elevation_max_deg)

    def inside(self, strokes: Rows) -> Rows:
        """Bring strokes (n, 5) within the robot's limits: the nearest ones that are."""
        robot, near = self.robot, strokes.copy()
        offset = np.hypot(near[:, A], near[:, B])
        near[:, :2] *= np.minimum(1.0, robot.offset_max / np.maximum(offset, 1e-12))[:, None]
        near[:, ELEVATION] = np.clip(near[:, ELEVATION], *self.elevations)
        near[:, SPEED] = np.clip(near[:, SPEED], robot.speed_min, robot.speed_max)
        middle, reach = math.radians(robot.azimuth_deg), math.radians(robot.azimuth_range_deg)
        turn = np.remainder(near[:, AZIMUTH] - middle + np.pi, 2.0 * np.pi) - np.pi
        if reach < np.pi:
            turn = np.clip(turn, -reach, reach)
        near[:, AZIMUTH] = np.remainder(middle + turn + np.pi, 2.0 * np.pi) - np.pi
        return near

    def allows(self, azimuths: Rows) -> NDArray[np.bool_]:
        """Whether the robot can strike in these directions."""
        away = np.remainder(azimuths - math.radians(self.robot.azimuth_deg) + np.pi, 2.0 * np.pi)
        allowed: NDArray[np.bool_] = (
            np.abs(away - np.pi) <= math.radians(self.robot.azimuth_range_deg) + 1e-12
        )
        return allowed


def limits_of(scene: Scene, constraints: Mapping[str, Any] | Robot | None, noise: Noise) -> Limits:
    """
    Read constraints; what they do not say is as in the scene's section `robot`.

    Raises
    ------
    ValueError
        Naming every wrong field.

    """
    spare = MARGIN * math.hypot(
        math.radians(noise.elevation_deg), noise.b / max(scene.cue.length, scene.ball.radius)
    )
    if isinstance(constraints, Robot):
        return Limits(constraints, None, spare)
    data = dict(constraints or {})
    first = data.pop('first_contact', None)
    mistakes = []
    others = [name for name in scene.balls if name != 'cue']
    if first is not None and str(first) not in others:
        there = ', '.join(others) or 'none'
        mistakes.append(Mistake(('first_contact',), f'there is no ball {first!r}; of {there}'))
    known = asdict(scene.robot)
    for key in data:
        if key not in known:
            mistakes.append(Mistake((str(key),), unknown(str(key), [*known, 'first_contact'])))
    robot = scene.robot
    try:
        robot = read(Robot, {**known, **{key: data[key] for key in data if key in known}})
    except InputError as error:
        mistakes += found_in(error)
    if mistakes:
        raise InputError(mistakes, 'constraints')
    return Limits(robot, None if first is None else str(first), spare)


def raised(scene: Scene, limits: Limits, strokes: Rows) -> Rows:
    """
    Raise the cue of strokes (n, 5) as far as it has to be for balls, cushions and cloth.

    Those that have room enough stay as they are; NaN where there is no room within the limits.
    """
    least, most = limits.elevations
    # a level cue, with errors, may point up
    low = np.maximum(strokes[:, ELEVATION], min(max(least, limits.spare), most))
    need = low.copy()
    for step in (COARSE, FINE):
        need = _first_free(scene, limits, strokes, need, step, low)
        if step == COARSE:
            need = np.maximum(need - COARSE + FINE, low)
    found = strokes.copy()
    found[:, ELEVATION] = np.where(need > low, need + FINE, need)
    found[~(found[:, ELEVATION] <= most + 1e-12)] = np.nan
    return found


def check_room(scene: Scene, limits: Limits) -> None:
    """Raise ValueError if the cue has no room for any stroke at the middle of the ball."""
    robot = limits.robot
    strokes = np.zeros((DIRECTIONS, 5))
    reach = math.radians(robot.azimuth_range_deg)
    strokes[:, AZIMUTH] = math.radians(robot.azimuth_deg) + np.linspace(-reach, reach, DIRECTIONS)
    strokes[:, SPEED] = robot.speed_min
    free = replace(limits, robot=replace(robot, elevation_max_deg=90.0))
    needed = raised(scene, free, strokes)[:, ELEVATION]
    if np.isnan(needed).all():
        raise ValueError(
            'constraints: azimuth_deg, azimuth_range_deg: in no direction that they allow there '
            'is room for the cue'
        )
    if np.nanmin(needed) > limits.elevations[1]:
        raise ValueError(
            f'constraints: elevation_max_deg: {robot.elevation_max_deg:g} is not allowed; with '
            'what is around the cue ball, and the errors of strokes, it must be at least '
            f'{math.degrees(np.nanmin(needed)):.3g} (degrees)'
        )


def _first_free(
    scene: Scene, limits: Limits, strokes: Rows, begin: Rows, step: float, low: Rows
) -> Rows:
    """Elevations from `begin` on, in steps, at which the cue has room with something to spare."""
    found = np.full(len(strokes), np.nan)
    tried, open_ = begin.copy(), np.arange(len(strokes))
    while len(open_):
        trial = strokes[open_]
        trial[:, ELEVATION] = np.maximum(tried[open_] - limits.spare, 0.0)
        normals, velocities = vectors_of(trial)
        blocked = np.isin(refusals_in(scene, normals, velocities), NO_ROOM)
        free = ~blocked & ~through_cloth(scene, normals, trial[:, ELEVATION])
        found[open_[free]] = tried[open_[free]]
        tried[open_] += step
        open_ = open_[~free & (tried[open_] <= limits.elevations[1] + step)]
    return found


def through_cloth(scene: Scene, normals: Rows, elevations: Rows) -> NDArray[np.bool_]:
    """Whether the cue would touch the cloth in front of the ball."""
    height = scene.ball.radius * (1.0 + normals[:, 2])
    low: NDArray[np.bool_] = height < scene.cue.tip_radius * np.cos(elevations)
    return low
