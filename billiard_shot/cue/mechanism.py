"""The mechanical cue: its geometry, its parts, and the limits of its joints."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)

from __future__ import annotations

from collections.abc import Iterable, Iterator
import dataclasses
from dataclasses import dataclass, replace
from functools import cached_property
import math
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array
from billiard_shot.scene.errors import InputError, Mistake
from billiard_shot.scene.fields import CheckedRecord, number, read, section
from billiard_shot.scene.files import read_document
from billiard_shot.scene.player import Robot
from billiard_shot.shot.stroke import axes


class LimitViolation(NamedTuple):
    """A violated limit, such as `stroke.speed`, and a text that says by how much."""

    limit: str
    text: str


class LimitError(ValueError):
    """A request that the mechanism cannot fulfil; `violations` lists all violated limits."""

    def __init__(self, violations: Iterable[LimitViolation]) -> None:
        self.violations = tuple(violations)
        super().__init__('; '.join(each.text for each in self.violations))


def check_range(
    limit: str, value: float, low: float, high: float, unit: str, reason: str = ''
) -> list[LimitViolation]:
    """
    Return a list of one violation if a value is outside [low, high]; else an empty list.

    `reason` says where the value or the limit comes from, if that is not obvious.
    """
    if low <= value <= high:
        return []
    side, allowed = ('above', high) if value > high else ('below', low)
    text = (
        f'{limit}: {value:.4g} {unit} is {abs(value - allowed):.3g} {unit} {side} the limit of '
        f'{allowed:.4g} {unit}'
    )
    return [LimitViolation(limit, f'{text} ({reason})' if reason else text)]


def raise_violations(violations: Iterable[LimitViolation]) -> None:
    """Raise a `LimitError` if there are any violations."""
    if found := tuple(violations):
        raise LimitError(found)


BOUNDS = {
    'machine_x': 0.05,
    'machine_y': 0.05,
    'machine_angle_deg': 3.0,
    'tip_right': 0.05,
    'tip_up': 0.05,
    'speed_scale': 0.1,
    'speed_bias': 0.1,
    'elevation_scale': 0.1,
    'elevation_bias_deg': 3.0,
}
"""Largest differences of plausible numbers from those of an exact machine, in their units."""


@dataclass(frozen=True, slots=True)
class Alignment(CheckedRecord):
    """
    Differences between the mechanism and its encoders; without any, both agree.

    Parameters
    ----------
    machine_x, machine_y : float
        Place on the table of the origin of the joints [m].
    machine_angle_deg : float
        Direction on the table of the joint base_x, counter-clockwise [degrees].
    tip_right, tip_up : float
        How far the tip is beside its joints' position, as seen along the stroke [m].
    speed_scale : float
        Speed of the cue per speed of its encoder, above 0.
    speed_bias : float
        Speed of the cue if its encoder says 0 [m/s].
    elevation_scale : float
        Elevation of the cue per elevation of its encoder, above 0.
    elevation_bias_deg : float
        Elevation of the cue if its encoder says 0 [degrees].

    """

    machine_x: float = number('m', minimum=-0.5, maximum=0.5, default=0.0)
    machine_y: float = number('m', minimum=-0.5, maximum=0.5, default=0.0)
    machine_angle_deg: float = number('degrees', minimum=-45, maximum=45, default=0.0)
    tip_right: float = number('m', minimum=-0.1, maximum=0.1, default=0.0)
    tip_up: float = number('m', minimum=-0.1, maximum=0.1, default=0.0)
    speed_scale: float = number('', minimum=0.5, maximum=2.0, default=1.0)
    speed_bias: float = number('m/s', minimum=-1.0, maximum=1.0, default=0.0)
    elevation_scale: float = number('', minimum=0.5, maximum=2.0, default=1.0)
    elevation_bias_deg: float = number('degrees', minimum=-45, maximum=45, default=0.0)

    def on_table(
        self, position: Array, azimuth: float, elevation: float
    ) -> tuple[Array, float, float]:
        """Return the pose of the tip for position (3,) [m] and angles [rad] of the encoders."""
        azimuth += math.radians(self.machine_angle_deg)
        elevation = self.elevation(elevation)
        return self._turn @ position + self._beside(azimuth, elevation), azimuth, elevation

    def by_encoders(
        self, position: Array, azimuth: float, elevation: float
    ) -> tuple[Array, float, float]:
        """Return position (3,) [m] and angles [rad] of the encoders for a pose of the tip."""
        position = self._turn.T @ (position - self._beside(azimuth, elevation))
        azimuth -= math.radians(self.machine_angle_deg)
        elevation = (elevation - math.radians(self.elevation_bias_deg)) / self.elevation_scale
        return position, azimuth, elevation

    def elevation(self, encoder: float) -> float:
        """Return the elevation of the cue for that of its encoder [rad]."""
        return self.elevation_scale * encoder + math.radians(self.elevation_bias_deg)

    def speed(self, encoder: float) -> float:
        """Return the speed of the cue for that of its encoder [m/s]."""
        return self.speed_scale * encoder + self.speed_bias

    def encoder_speed(self, speed: float) -> float:
        """Return the speed of the encoder for that of the cue [m/s]."""
        return (speed - self.speed_bias) / self.speed_scale

    def check_plausible(self, limit: float) -> None:
        """Raise ValueError with each number that differs by more than `limit` times its bound."""
        wrong = [
            f'alignment.{name} must be from {exact - limit * BOUNDS[name]:g} to '
            f'{exact + limit * BOUNDS[name]:g}, got {value:g}'
            for name, (value, exact) in self._differences().items()
            if abs(value - exact) > limit * BOUNDS[name] * (1.0 + 1e-9)
        ]
        if wrong:
            raise ValueError(
                f'{"; ".join(wrong)}; the parameter alignment_limit widens the ranges'
            )

    def __str__(self) -> str:
        differences = self._differences().items()
        return ', '.join(f'{name} {value:g}' for name, (value, _) in differences) or 'exact'

    def _differences(self) -> dict[str, tuple[float, float]]:
        """Numbers that differ from those of an exact machine, and the latter."""
        numbers = {name: (getattr(self, name), getattr(EXACT, name)) for name in BOUNDS}
        return {name: each for name, each in numbers.items() if each[0] != each[1]}

    @property
    def _turn(self) -> Array:
        angle = math.radians(self.machine_angle_deg)
        cosine, sine = math.cos(angle), math.sin(angle)
        return np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])

    def _beside(self, azimuth: float, elevation: float) -> NDArray[np.float64]:
        """Vector from the turned position of the encoders to the tip (3,) [m]."""
        right, up, _ = np.array(axes(elevation, azimuth))
        return (
            np.array([self.machine_x, self.machine_y, 0.0])
            + self.tip_right * right
            + self.tip_up * up
        )


EXACT = Alignment()
"""The alignment of a machine that stands and measures as its encoders say."""


@dataclass(frozen=True, slots=True)
class Incline(CheckedRecord):
    """
    The triangle of the incline.

    Parameters
    ----------
    base, arm : float
        Distances from the pivot to the foot and to the head of the actuator [m], above 0.
    level_angle : float
        Angle between base and arm when the cue is level [rad], above 0.

    """

    base: float = number('m', above=0, default=0.5)
    arm: float = number('m', above=0, default=0.3)
    level_angle: float = number('rad', above=0, maximum=math.pi, default=1.0)

    def length(self, elevation: float) -> float:
        """
        Length of the actuator [m] for an elevation [rad].

        This is the law of cosines as a sum of squares, which is accurate at small angles too.
        """
        half_chord = math.sqrt(self.base * self.arm) * math.sin(
            0.5 * (elevation + self.level_angle)
        )
        return math.hypot(self.base - self.arm, 2 * half_chord)

    def elevation(self, length: float) -> float:
        """
        Elevation of the cue [rad] for a length of the actuator [m].

        This is the half-angle form of the law of cosines, which is accurate for flat triangles
        too (W. Kahan, "Miscalculating area and angles of a needle-like triangle", 2014).

        Raises
        ------
        LimitError
            If the sides do not make a triangle.

        """
        low, high = self.sides
        raise_violations(check_range('incline', length, low, high, 'm', 'sides of the triangle'))
        short = math.sqrt((length - low) * (length + low))
        long = math.sqrt((high - length) * (high + length))
        return 2 * math.atan2(short, long) - self.level_angle

    def length_per_elevation(self, length: float) -> float:
        """Rate of change of the actuator's length with the elevation, at a length [m/rad]."""
        angle = self.elevation(length) + self.level_angle
        return self.base * self.arm * math.sin(angle) / length

    @property
    def sides(self) -> tuple[float, float]:
        """Lengths of the actuator at which the triangle is flat [m]."""
        return abs(self.base - self.arm), self.base + self.arm


@dataclass(frozen=True, slots=True)
class MovingPart(CheckedRecord):
    """One moving part, as a box of uniform density."""

    mass: float = number('kg', above=0)
    length: float = number('m', above=0)  # along the axis x of the part's frame
    width: float = number('m', above=0)  # along y
    height: float = number('m', above=0)  # along z

    @property
    def size(self) -> NDArray[np.float64]:
        """Length, width and height (3,) [m]."""
        return np.array([self.length, self.width, self.height])

    @property
    def inertia(self) -> NDArray[np.float64]:
        """Moments of inertia about the axes through its centre (3,) [kg m^2]."""
        squares = self.size**2
        moments: NDArray[np.float64] = self.mass / 12 * (np.roll(squares, 1) + np.roll(squares, 2))
        return moments


def section_of(kind: Any, *numbers: float) -> Any:
    """Section whose default has these numbers."""
    return dataclasses.field(
        default_factory=lambda: kind(*numbers), metadata=section(kind).metadata
    )


@dataclass(frozen=True, slots=True)
class Parts(CheckedRecord):
    """
    The moving parts, each named after the joint that moves it.

    Parameters
    ----------
    base_x : MovingPart
        The bridge across the table, above the trolley.
    base_y : MovingPart
        The trolley on the bridge, above the highest position of the pivot.
    base_z : MovingPart
        The column through the trolley, with the turntable at its lower end.
    azimuth : MovingPart
        The turntable, centred on the pivot.
    incline : MovingPart
        The box with the linear bearings and the drive of the stroke. The cue lies in its lower
        side, because a box around a level cue would touch the cloth.
    stroke : MovingPart
        The cue, which ends at the tip.

    """

    base_x: MovingPart = section_of(MovingPart, 60.0, 0.2, 4.2, 0.2)
    base_y: MovingPart = section_of(MovingPart, 15.0, 0.3, 0.3, 0.15)
    base_z: MovingPart = section_of(MovingPart, 10.0, 0.1, 0.1, 1.3)
    azimuth: MovingPart = section_of(MovingPart, 3.0, 0.2, 0.2, 0.04)
    incline: MovingPart = section_of(MovingPart, 6.0, 0.5, 0.1, 0.1)
    stroke: MovingPart = section_of(MovingPart, 0.5018, 1.0, 0.02, 0.02)


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
class Axis(CheckedRecord):
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
class Mechanism(CheckedRecord):
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

    RULES: ClassVar = (_stroke_from_zero, _incline_within_its_triangle, _travels_above_the_balls)
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
