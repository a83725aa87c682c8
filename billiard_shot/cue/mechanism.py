"""The mechanical cue: its joints and what they can do, with units and ranges."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from __future__ import annotations

from collections.abc import Iterator
import dataclasses
from dataclasses import dataclass
from functools import cached_property
import math
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.cue.incline import Incline
from billiard_shot.cue.parts import Parts
from billiard_shot.scene.checks import check, read
from billiard_shot.scene.fields import number, section
from billiard_shot.scene.mistakes import InputError, Mistake
from billiard_shot.scene.yaml_file import read_document

JOINTS = ('base_x', 'base_y', 'base_z', 'azimuth', 'incline', 'stroke')
"""
Joints, in the order of every array of joints.

`base_x base_y base_z` place the incline's pivot in the frame `table` [m]; `azimuth` turns it about
the vertical [rad]; `incline` is the length of its actuator [m]; `stroke` is how far the cue has
moved along its axis from where it is drawn back fully [m].
"""
BASE_X, BASE_Y, BASE_Z, AZIMUTH, INCLINE, STROKE = range(6)
UNITS = ('m', 'm', 'm', 'rad', 'm', 'm')


def _range_of_an_axis(axis: Any) -> Iterator[Mistake]:
    if not axis.least < axis.most:
        yield Mistake(
            ('least',), (f'{axis.least:g} is not allowed; it must be below most, {axis.most:g}')
        )


@dataclass(frozen=True, slots=True)
class Axis:
    """
    What one joint can do; the unit u is m, or rad for `azimuth`.

    Parameters
    ----------
    least, most : float
        Range of its position [u].
    speed, acceleration, jerk : float
        Largest magnitudes [u/s, u/s^2, u/s^3], above 0.

    """

    RULES: ClassVar = (_range_of_an_axis,)
    least: float = number('u')
    most: float = number('u')
    speed: float = number('u/s', above=0)
    acceleration: float = number('u/s^2', above=0)
    jerk: float = number('u/s^3', above=0)

    def __post_init__(self) -> None:
        check(self)


def _axis(*numbers: float) -> Any:
    return dataclasses.field(
        default_factory=lambda: Axis(*numbers), metadata=section(Axis).metadata
    )


def _stroke_from_zero(mechanism: Any) -> Iterator[Mistake]:
    if mechanism.stroke.least != 0.0:
        yield Mistake(
            ('stroke', 'least'), (f'{mechanism.stroke.least:g} is not allowed; it must be 0 (m)')
        )


def _incline_within_its_triangle(mechanism: Any) -> Iterator[Mistake]:
    triangle, incline = mechanism.triangle, mechanism.incline
    if not triangle.shortest <= incline.least < incline.most <= triangle.longest:
        yield Mistake(
            ('incline',),
            (
                f'{incline.least:g} to {incline.most:g} is not allowed; it must lie within '
                f'{triangle.shortest:g} to {triangle.longest:g}, the lengths of the triangle (m)'
            ),
        )
        return
    low, high = (triangle.elevation(length) for length in (incline.least, incline.most))
    if not low <= mechanism.least_elevation < mechanism.most_elevation <= high:
        yield Mistake(
            ('most_elevation',),
            (
                f'{mechanism.most_elevation:g}, and least_elevation '
                f'{mechanism.least_elevation:g}, is not allowed; they must ascend, within '
                f'{low:.4g} to {high:.4g}, which the incline reaches (rad)'
            ),
        )


@dataclass(frozen=True)
class Mechanism:
    """
    A steel cue on linear bearings in a box, on an incline that a carriage moves over the table.

    Parameters
    ----------
    base_x, base_y, base_z, azimuth, incline, stroke : Axis
        The joints, see `JOINTS`. The range of `stroke` starts at 0.
    triangle : Incline
        Geometry of the incline; the range of the joint `incline` lies within its lengths.
    least_elevation, most_elevation : float
        Range in which the cue may play [rad], 0 to pi/2.
    least_speed : float
        Slowest stroke that the drive can hold steady [m/s], above 0.
    force : float
        Largest force of the stroke's drive [N], above 0.
    reach : float
        From the pivot's foot point on the cue's axis to the tip, cue drawn back [m], at least 0.
    drop : float
        How far the cue's axis passes below the pivot, at right angles to it [m], at least 0.
    steady_time : float
        For how long the cue moves at constant speed before it meets the ball [s], above 0.
    contact_time : float
        For how long the drive lets go of the cue from the moment it meets the ball [s], above 0.
        Leather tips touch the ball for 1 to 2 ms (Alciatore, "Cue tip contact time",
        billiards.colostate.edu).
    travel_height : float
        Height of the tip above the cloth when the carriage travels [m], above 0; above the balls.
    parts : Parts
        Masses and sizes of the moving parts, for the robot model (URDF).

    """

    RULES: ClassVar = (_stroke_from_zero, _incline_within_its_triangle)
    base_x: Axis = _axis(-2.5, 2.5, 1.0, 2.0, 20.0)
    base_y: Axis = _axis(-2.0, 2.0, 1.0, 2.0, 20.0)
    base_z: Axis = _axis(0.0, 1.2, 0.5, 2.0, 20.0)
    azimuth: Axis = _axis(-math.pi, math.pi, 1.5, 4.0, 40.0)
    incline: Axis = _axis(0.40, 0.72, 0.1, 0.5, 5.0)
    stroke: Axis = _axis(0.0, 0.6, 6.0, 150.0, 15000.0)
    triangle: Incline = section(Incline, optional=True)
    least_elevation: float = number('rad', least=0, most=math.pi / 2, default=0.0)
    most_elevation: float = number('rad', least=0, most=math.pi / 2, default=1.2)
    least_speed: float = number('m/s', above=0, default=0.05)
    force: float = number('N', above=0, default=100.0)
    reach: float = number('m', least=0, default=0.3)
    drop: float = number('m', least=0, default=0.08)
    steady_time: float = number('s', above=0, default=0.02)
    contact_time: float = number('s', above=0, default=0.002)
    travel_height: float = number('m', above=0, default=0.1)
    parts: Parts = section(Parts, optional=True)

    def __post_init__(self) -> None:
        check(self)

    @classmethod
    def load(cls, path: str | Path) -> Mechanism:
        """
        Read a mechanism from a YAML file; '' is the default one.

        Raises
        ------
        ValueError
            Naming file, line, field, value and allowed range of every mistake.

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
