"""The mechanical cue: its geometry and the limits of its joints, with units and ranges."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
import math
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.cue.alignment import Alignment
from billiard_shot.cue.incline import Incline
from billiard_shot.cue.parts import Parts, section_of
from billiard_shot.scene.checks import check, read
from billiard_shot.scene.errors import InputError, Mistake
from billiard_shot.scene.fields import number, section
from billiard_shot.scene.player import Robot
from billiard_shot.scene.yaml_file import read_document

JOINTS = ('base_x', 'base_y', 'base_z', 'azimuth', 'incline', 'stroke')
"""
Joints, in the order of every array of joints.

`base_x`, `base_y` and `base_z` are the position of the incline's pivot in the frame `table` [m].
`azimuth` is its angle about the vertical [rad]. `incline` is the length of its actuator [m].
`stroke` is the distance of the cue along its axis from the fully drawn-back position [m].
"""
BASE_X, BASE_Y, BASE_Z, AZIMUTH_JOINT, INCLINE, STROKE = range(6)
UNITS = ('m', 'm', 'm', 'rad', 'm', 'm')


def _range_of_an_axis(axis: Any) -> Iterator[Mistake]:
    if not axis.min < axis.max:
        yield Mistake(('min',), f'must be below max, {axis.max:g}, got {axis.min:g}')


@dataclass(frozen=True, slots=True)
class Axis:
    """
    Limits of one joint; the unit u is m, or rad for `azimuth`.

    Parameters
    ----------
    min, max : float
        Range of the position [u].
    speed, acceleration, jerk : float
        Largest magnitudes [u/s, u/s^2, u/s^3], above 0.

    """

    RULES: ClassVar = (_range_of_an_axis,)
    min: float = number('u')
    max: float = number('u')
    speed: float = number('u/s', above=0)
    acceleration: float = number('u/s^2', above=0)
    jerk: float = number('u/s^3', above=0)

    def __post_init__(self) -> None:
        check(self)


def _stroke_from_zero(mechanism: Any) -> Iterator[Mistake]:
    if mechanism.stroke.min != 0.0:
        yield Mistake(('stroke', 'min'), f'must be 0, got {mechanism.stroke.min:g} (m)')


def _incline_within_its_triangle(mechanism: Any) -> Iterator[Mistake]:
    geometry, incline = mechanism.incline_geometry, mechanism.incline
    shortest, longest = geometry.sides
    # At these lengths the triangle is flat, and the actuator cannot turn the incline.
    if not shortest < incline.min < incline.max < longest:
        yield Mistake(
            ('incline',),
            f'must be between {shortest:g} and {longest:g}, where the triangle of '
            f'incline_geometry is flat, got {incline.min:g} to {incline.max:g} (m)',
        )
        return
    low, high = (geometry.elevation(length) for length in (incline.min, incline.max))
    if not low <= mechanism.min_elevation < mechanism.max_elevation <= high:
        yield Mistake(
            ('max_elevation',),
            f'must be above min_elevation, both within {low:.4g} to {high:.4g}, the range of the '
            f'incline, got {mechanism.max_elevation:g} and {mechanism.min_elevation:g} (rad)',
        )


def min_travel_height(mechanism: Any) -> float:
    """
    Least height of the pivot [m] at which the tip is at `travel_height` or above.

    That holds with the alignment and, because the alignment may be wrong, also without.
    """
    drop = mechanism.axis_drop + max(-mechanism.alignment.tip_up, 0.0)
    return float(mechanism.travel_height + math.hypot(mechanism.reach, drop))


def _travels_above_the_balls(mechanism: Any) -> Iterator[Mistake]:
    needed = min_travel_height(mechanism)
    if mechanism.base_z.max < needed:
        yield Mistake(
            ('base_z', 'max'),
            f'must be at least {needed:.4g}, or the tip cannot travel at travel_height, got '
            f'{mechanism.base_z.max:g} (m)',
        )


@dataclass(frozen=True)
class Mechanism:
    """
    A steel cue on linear bearings in a box, on an incline that a carriage moves over the table.

    Parameters
    ----------
    base_x, base_y, base_z, azimuth, incline, stroke : Axis
        The joints, see `JOINTS`. The range of `stroke` starts at 0. The range of `base_z` reaches
        `min_travel_height`.
    incline_geometry : Incline
        Triangle of the incline; it is not flat anywhere in the range of the joint `incline`.
    min_elevation, max_elevation : float
        Range of the cue's elevation in a stroke [rad], 0 to pi/2.
    min_speed : float
        Slowest stroke whose speed the drive can hold constant [m/s], above 0.
    max_force : float
        Largest force of the stroke's drive [N], above 0.
    reach : float
        Distance along the drawn-back cue from the point nearest to the pivot to the tip [m], at
        least 0.
    axis_drop : float
        Distance of the cue's axis below the pivot, perpendicular to the axis [m], at least 0.
    steady_time : float
        Time at constant speed before the cue meets the ball [s], above 0.
    contact_time : float
        Time for which the drive releases the cue, from the moment it meets the ball [s], above 0;
        or longer, if the tip is predicted to touch the ball for longer.
        Leather tips touch the ball for 1 to 2 ms (Alciatore, "Cue tip contact time",
        billiards.colostate.edu).
    travel_height : float
        Height of the tip above the cloth when the carriage travels [m], above 0. It must be above
        the balls.
    parts : Parts
        Masses and sizes of the moving parts, for the robot model (URDF).
    alignment : Alignment
        Where the tip is beside where the encoders say it is. Poses, elevations and speeds of the
        cue are the aligned ones; joints are those of the encoders.

    """

    RULES: ClassVar = (
        _stroke_from_zero,
        _incline_within_its_triangle,
        _travels_above_the_balls,
    )
    base_x: Axis = section_of(Axis, -2.5, 2.5, 1.0, 2.0, 20.0)
    base_y: Axis = section_of(Axis, -2.0, 2.0, 1.0, 2.0, 20.0)
    base_z: Axis = section_of(Axis, 0.0, 1.2, 0.5, 2.0, 20.0)
    azimuth: Axis = section_of(Axis, -math.pi, math.pi, 1.5, 4.0, 40.0)
    incline: Axis = section_of(Axis, 0.40, 0.72, 0.1, 0.5, 5.0)
    stroke: Axis = section_of(Axis, 0.0, 0.6, 6.0, 150.0, 15000.0)
    incline_geometry: Incline = section(Incline, optional=True)
    min_elevation: float = number('rad', minimum=0, maximum=math.pi / 2, default=0.0)
    max_elevation: float = number('rad', minimum=0, maximum=math.pi / 2, default=1.2)
    min_speed: float = number('m/s', above=0, default=0.05)
    max_force: float = number('N', above=0, default=100.0)
    reach: float = number('m', minimum=0, default=0.3)
    axis_drop: float = number('m', minimum=0, default=0.08)
    steady_time: float = number('s', above=0, default=0.02)
    contact_time: float = number('s', above=0, default=0.002)
    travel_height: float = number('m', above=0, default=0.1)
    parts: Parts = section(Parts, optional=True)
    alignment: Alignment = section(Alignment, optional=True)

    def __post_init__(self) -> None:
        check(self)

    @classmethod
    def load(cls, path: str | Path) -> Mechanism:
        """
        Read a mechanism from a YAML file; '' stands for the default mechanism.

        Raises
        ------
        ValueError
            With file, line, field, value and allowed range of every mistake.

        """
        if str(path) == '':
            return cls()
        data, lines, mistakes = read_document(Path(path))
        try:
            mechanism = read(cls, data)
        except InputError as error:
            mistakes += error.mistakes
        if mistakes:
            raise InputError(mistakes, f'mechanism {path}', lines) from None
        return mechanism

    def elevation(self, length: float) -> float:
        """Elevation of the cue [rad] for a length of the incline's actuator [m]."""
        return self.alignment.elevation(self.incline_geometry.elevation(length))

    def length_per_elevation(self, length: float) -> float:
        """Rate of change of that length with the elevation [m/rad]."""
        per_encoder = self.incline_geometry.length_per_elevation(length)
        return per_encoder / self.alignment.elevation_scale

    @property
    def elevations(self) -> tuple[float, float]:
        """Range of the cue's elevation in a stroke that the incline reaches [rad]."""
        low, high = map(self.elevation, (self.incline.min, self.incline.max))
        return max(self.min_elevation, low), min(self.max_elevation, high)

    def within(self, robot: Robot) -> Robot:
        """Narrow limits of strokes to those of the mechanism; ValueError if none is left."""
        low, high = map(math.degrees, self.elevations)
        slowest, fastest = map(self.alignment.speed, (self.min_speed, self.stroke.speed))
        return replace(
            robot,
            speed_min=max(robot.speed_min, slowest),
            speed_max=min(robot.speed_max, fastest),
            elevation_min_deg=max(robot.elevation_min_deg, low),
            elevation_max_deg=min(robot.elevation_max_deg, high),
        )

    @cached_property
    def axes(self) -> tuple[Axis, ...]:
        """The joints' axes, in the order of `JOINTS`."""
        return tuple(getattr(self, name) for name in JOINTS)

    @cached_property
    def speeds(self) -> NDArray[np.float64]:
        """Largest speeds of the joints (6,)."""
        return np.array([axis.speed for axis in self.axes])

    @cached_property
    def accelerations(self) -> NDArray[np.float64]:
        """Largest accelerations of the joints (6,)."""
        return np.array([axis.acceleration for axis in self.axes])

    @cached_property
    def jerks(self) -> NDArray[np.float64]:
        """Largest jerks of the joints (6,)."""
        return np.array([axis.jerk for axis in self.axes])
