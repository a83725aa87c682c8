"""A stroke: where the cue hits the ball and how it moves, stated in one of three ways."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
import math
from math import cos, hypot, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.notebook import Shown
from billiard_shot.numerics import rounding
from billiard_shot.records import Floats, Storage, Triple
from billiard_shot.scene.errors import refused, unknown
from billiard_shot.scene.fields import as_float, as_floats, LARGEST, positive
from billiard_shot.scene.files import read_yaml
from billiard_shot.scene.player import A, AZIMUTH, B, ELEVATION, IN_DEGREES, SPEED


@inner
def axes(elevation: float, azimuth: float) -> tuple[Triple, Triple, Triple]:
    """Find unit vectors to the right, up and along a stroke [rad], as seen by who plays it."""
    sin_e, cos_e, sin_t, cos_t = sin(elevation), cos(elevation), sin(azimuth), cos(azimuth)
    right, up = (sin_t, -cos_t, 0.0), (sin_e * cos_t, sin_e * sin_t, cos_e)
    return right, up, (cos_e * cos_t, cos_e * sin_t, -sin_e)


@inner
def write_vectors(stroke: Floats, elevation: float, normal: Floats, axis: Floats) -> None:
    """
    Write the unit normal and the axis of a stroke (5,) at an elevation [rad].

    If the tip misses the ball, the normal is at a right angle to the stroke.
    """
    a, b = stroke[A], stroke[B]
    right, up, along = axes(elevation, stroke[AZIMUTH])
    depth = sqrt(max(1.0 - a * a - b * b, 0.0))
    length = hypot(hypot(a, b), depth)
    for k in range(3):
        axis[k] = along[k]
        normal[k] = (a * right[k] + b * up[k] - depth * along[k]) / length


def _example(storage: Storage) -> tuple[Any, ...]:
    return storage.zeros(1, 5), storage.zeros(1, 3), storage.zeros(1, 3)


@entry(_example)
def write_strokes(offsets: Floats, normals: Floats, velocities: Floats) -> None:
    """
    Find the vectors of strokes; those of equal strokes are equal to the last bit on all machines.

    Parameters
    ----------
    offsets : (n, 5) floats
        a, b, elevation, azimuth, speed, as of `Stroke.from_offsets`.
    normals, velocities : (n, 3) floats, written
        Unit vectors from the centre of the ball to the tip; velocities of the cue [m/s].

    """
    for i in range(len(offsets)):
        stroke, velocity = offsets[i], velocities[i]
        write_vectors(stroke, stroke[ELEVATION], normals[i], velocity)
        for k in range(3):
            velocity[k] *= stroke[SPEED]


Numbers = Sequence[float] | NDArray[np.float64]

SPEED_RANGE = 1.0 / LARGEST, LARGEST  # m/s
SPEED_HINT = '; the cue of a player moves at 0.1 to 12 m/s'


@dataclass(frozen=True, slots=True, init=False)
class Stroke(Shown):
    """
    A stroke of the cue at a ball at rest.

    Parameters
    ----------
    normal : (3,) array_like
        Outward normal of the ball where the tip hits it, frame `table`; any length but 0.
    velocity : (3,) array_like
        Velocity of the cue [m/s], frame `table`; 1e-12 to 1e12 long.
    axis : bool
        Whether `normal` is where the axis of the cue meets the ball, so that a rounded tip touches
        it elsewhere. Else the tip touches the ball there, whatever its shape.

    Raises
    ------
    ValueError
        If a number is not finite or out of range, or a vector is zero or has more or fewer than
        three numbers. An unplayable stroke is not an error; see `Shot.status` and
        `Shot.message`.

    """

    normal: Triple  # of length 1
    velocity: Triple
    axis: bool
    # How the tip passes the ball, in the terms in which the stroke was stated; empty if it hits.
    miss: str = field(compare=False, repr=False)

    def __init__(
        self, normal: Numbers, velocity: Numbers, *, axis: bool = False, miss: str = ''
    ) -> None:
        x, y, z = _direction('normal', normal, 3)
        u, v, w = read_numbers('velocity', velocity, 3)
        _check_speed('velocity', velocity, math.hypot(u, v, w), 'of length ')
        object.__setattr__(self, 'normal', (x, y, z))
        object.__setattr__(self, 'velocity', (u, v, w))
        object.__setattr__(self, 'axis', bool(axis))
        object.__setattr__(self, 'miss', miss)

    def __repr__(self) -> str:
        stated = ', '.join(f'{name}={value:.4g}' for name, value in self.in_degrees().items())
        behind = sum(n * v for n, v in zip(self.normal, self.velocity, strict=True)) >= 0.0
        return f'Stroke({stated}{", misses the ball" if self.miss or behind else ""})'

    def in_degrees(self) -> dict[str, float]:
        """
        Return a, b, elevation_deg, azimuth_deg and speed, as files of strokes have them.

        The numbers are rounded to six digits after the point.
        """
        a, b, elevation, azimuth, speed = self.offsets
        numbers = {
            'a': a,
            'b': b,
            'elevation_deg': math.degrees(elevation),
            'azimuth_deg': math.degrees(azimuth),
            'speed': speed,
        }
        # rounded, so that rounding errors of angles are 0; + 0.0 makes 0 of -0
        return {name: round(value, 6) + 0.0 for name, value in numbers.items()}

    @classmethod
    def from_offsets(
        cls,
        a: float = 0.0,
        b: float = 0.0,
        elevation: float | None = None,
        azimuth: float | None = None,
        speed: float | None = None,
        *,
        elevation_deg: float | None = None,
        azimuth_deg: float | None = None,
        axis: bool = False,
    ) -> Stroke:
        """
        State a stroke as players do.

        Parameters
        ----------
        a, b : float
            Where the tip hits, to the right and up as seen along the stroke, in ball radii.
        elevation : float
            Angle by which the stroke points down [rad], at most pi/2; 0 by default. `predict`
            refuses a stroke that points up.
        azimuth : float
            Direction of its horizontal part, counter-clockwise from +x [rad], -2 pi to 2 pi; 0 by
            default.
        speed : float
            Of the cue [m/s], 1e-12 to 1e12.
        elevation_deg, azimuth_deg : float
            The same angles in degrees, instead of `elevation` and `azimuth`.
        axis : bool
            Whether a and b are where the axis of the cue meets the ball, see `Stroke`.

        Raises
        ------
        ValueError
            If a number is missing, not finite or out of range, or an angle is given twice.

        """
        for name, value in (('a', a), ('b', b)):
            _number(name, value)
        elevation = read_angle('elevation', elevation, elevation_deg, 0.0, 0.5 * math.pi)
        azimuth = read_angle('azimuth', azimuth, azimuth_deg, -2.0 * math.pi, 2.0 * math.pi)
        if speed is None:
            raise ValueError(f'speed is missing; it must be above 0 (m/s){SPEED_HINT}')
        _check_speed('speed', speed, _number('speed', speed))
        return stroke_at(a, b, elevation, azimuth, speed, axis=axis)

    @classmethod
    def from_pose(
        cls, position: Numbers, quaternion: Numbers, speed: float, ball: Numbers
    ) -> Stroke:
        """
        Find where the axis of a cue that moves straight ahead meets the ball.

        Parameters
        ----------
        position : (3,) array_like
            Of the tip [m], frame `table`.
        quaternion : (4,) array_like
            Orientation of the tip frame, x y z w, any length but 0; +x points along the stroke.
        speed : float
            Of the cue along +x [m/s], 1e-12 to 1e12.
        ball : (3,) array_like
            Centre of the ball [m]; it lies on the cloth, so that z is its radius.

        """
        centre = np.array(read_numbers('ball', ball, 3))
        away = np.array(read_numbers('position', position, 3)) - centre
        x, y, z, w = _direction('quaternion', quaternion, 4)
        radius = positive('ball', centre[2].item(), 'm; z, the radius')
        _check_speed('speed', speed, _number('speed', speed))
        along = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)])
        ahead = -(away @ along)  # distance to the point of the path next to the ball's centre
        aside = away + ahead * along
        distance = math.hypot(*aside)
        if distance >= radius:
            return cls(
                aside,
                speed * along,
                axis=True,
                miss=(
                    'position, quaternion must put the axis of the tip nearer to the centre of '
                    f'the ball than its radius, {radius:.4g}, got {distance:.4g} (m)'
                ),
            )
        depth = math.sqrt(radius * radius - distance * distance)
        if ahead - depth < -1e-9 * radius:  # less is rounding of a tip that touches the ball
            # ahead of it is at most the point where its axis leaves the ball
            return cls(
                aside + depth * along,
                speed * along,
                axis=True,
                miss=(
                    f'position must be in front of the ball, got {tuple(position)}, '
                    f'{depth - ahead:.4g} m past where the tip would meet it'
                ),
            )
        return cls(aside - depth * along, speed * along, axis=True)

    def touching(self, tip_curvature: float) -> Stroke:
        """
        Find where a rounded tip touches the ball.

        The centre of the tip's sphere is on the axis, at the distance `tip_curvature` from the
        surface of the ball: an axis that passes the ball's centre at the distance p touches the
        ball at the offset p / (1 + tip_curvature).

        Parameters
        ----------
        tip_curvature : float
            Radius of the tip's sphere, in radii of the ball.

        """
        if not self.axis or self.miss or tip_curvature == 0.0:
            return self
        along = np.array(self.velocity) / self.speed
        aside = np.array(self.normal) - (along @ self.normal) * along
        beside = aside / (1.0 + tip_curvature)
        depth = math.sqrt(max(1.0 - float(beside @ beside), 0.0))
        return Stroke(beside - depth * along, self.velocity)

    @property
    def speed(self) -> float:
        """Speed of the cue [m/s]."""
        return math.hypot(*self.velocity)

    @property
    def offsets(self) -> tuple[float, float, float, float, float]:
        """
        The arguments of `from_offsets` that make this stroke, with its `axis`.

        The azimuth is 0 if the stroke is vertical.
        """
        x, y, z = self.velocity
        elevation = math.atan2(-z, math.hypot(x, y)) + 0.0  # 0, not -0
        azimuth = math.atan2(y, x)
        right, up, _ = np.array(axes(elevation, azimuth))
        return (
            float(right @ self.normal),
            float(up @ self.normal),
            elevation,
            azimuth,
            self.speed,
        )


def stroke_at(
    a: float, b: float, elevation: float, azimuth: float, speed: float, *, axis: bool = False
) -> Stroke:
    """Make a stroke as `Stroke.from_offsets`, with angles [rad] of any size."""
    miss = ''
    if 1.0 - a * a - b * b <= 0.0:
        miss = f'a, b must have a² + b² below 1, got ({a:g}, {b:g})'
    normals, velocities = vectors_of(np.array([(a, b, elevation, azimuth, speed)], float))
    return Stroke(normals[0], velocities[0], axis=axis, miss=miss)


def vectors_of(offsets: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Compute the normals, of length 1, and cue velocities (n, 3) of many strokes.

    Parameters
    ----------
    offsets : (n, 5) float array
        a, b, elevation, azimuth, speed, as of `Stroke.from_offsets`. If the tip misses the ball,
        its normal is at a right angle to the stroke.

    """
    run, count = write_strokes.current(), len(offsets)
    normals, velocities = run.storage.zeros(count, 3), run.storage.zeros(count, 3)
    run(run.storage.array(offsets), normals, velocities)
    return np.reshape(normals, (-1, 3)), np.reshape(velocities, (-1, 3))


def playable_offsets(offsets: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the arguments of `Stroke.from_offsets` (n, 5); NaN in a row that it refuses."""
    _, _, elevation, azimuth, speed = offsets.T
    playable = np.isfinite(offsets).all(axis=1)
    playable &= (np.abs(elevation) <= 0.5 * math.pi) & (np.abs(azimuth) <= 2.0 * math.pi)
    playable &= (speed >= SPEED_RANGE[0]) & (speed <= SPEED_RANGE[1])
    return np.where(playable[:, np.newaxis], offsets, np.nan)


def unit_rows(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """
    Make each row of a matrix 1 long; NaN where it is zero or not finite.

    A row that is 1 long within rounding stays as it is, so that a stroke that is read from a file
    is the one that was written.
    """
    with np.errstate(invalid='ignore', divide='ignore', over='ignore'):
        is_unit = np.abs((rows**2).sum(axis=1, keepdims=True) - 1.0) <= 2.0 * rounding.SUM
        # scaled first: squares of very large or small numbers would not be finite, or zero
        scaled = rows / np.abs(rows).max(axis=1, keepdims=True, initial=0.0)
        units = scaled / np.sqrt((scaled**2).sum(axis=1, keepdims=True))
    made: NDArray[np.float64] = np.where(is_unit, rows, units)
    return made


def playable_rows(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return velocities of the cue (n, 3) [m/s]; NaN in a row if no stroke can have it."""
    with np.errstate(over='ignore'):
        speeds = np.sqrt((rows**2).sum(axis=1, keepdims=True))
    playable: NDArray[np.float64] = np.where(
        (speeds >= SPEED_RANGE[0]) & (speeds <= SPEED_RANGE[1]), rows, np.nan
    )
    return playable


def _number(name: str, value: object) -> float:
    number = as_float(value)
    if not math.isfinite(number):
        raise refused(value, 'a finite number', name)
    return number


def read_angle(
    name: str, radians: float | None, degrees: float | None, least: float, most: float
) -> float:
    """
    Read an angle [rad] given in one of two units; 0 by default.

    The message for one above `most` in size names the range that strokes can have.
    """
    if radians is not None and degrees is not None:
        raise ValueError(f'{name} must not be given together with {name}_deg')
    if degrees is not None:
        angle = math.radians(_number(f'{name}_deg', degrees))
        if abs(angle) > most:
            allowed = f'{math.degrees(least):g} to {math.degrees(most):g}'
            raise refused(degrees, allowed, f'{name}_deg', 'degrees')
        return angle
    angle = 0.0 if radians is None else _number(name, radians)
    if abs(angle) > most:
        error = refused(radians, f'{least:.4g} to {most:.4g}', name, 'rad')
        raise ValueError(f'{error}; for degrees, give {name}_deg={radians!r}')
    return angle


def _check_speed(name: str, value: object, speed: float, what: str = '') -> None:
    low, high = SPEED_RANGE
    # the length of a vector is rounded
    if not low * (1.0 - rounding.SUM) <= speed <= high * (1.0 + rounding.SUM):
        allowed = f'{what}above 0' if speed <= 0.0 else f'{what}{low:g} to {high:g}'
        raise refused(value, allowed, name, 'm/s', SPEED_HINT)


def read_numbers(name: str, values: Numbers, count: int) -> list[float]:
    """Read as many finite numbers as `count` says."""
    if isinstance(values, str) or not hasattr(values, '__len__') or len(values) != count:
        raise refused(values, f'{count} finite numbers', name)
    return [_number(name, value) for value in values]


def read_rows(name: str, values: ArrayLike | None, columns: int) -> NDArray[np.float64]:
    """Read numbers of shape (n, columns)."""
    rows = as_floats(values)
    if rows.ndim != 2 or rows.shape[1] != columns:
        raise ValueError(f'{name} must be of shape (n, {columns}), got {rows.shape}')
    return rows


def _direction(name: str, values: Numbers, count: int) -> list[float]:
    found = read_numbers(name, values, count)
    if not any(found):
        raise ValueError(f'{name} must not be zero, got {values!r}')
    if abs(sum(each * each for each in found) - 1.0) <= 2.0 * rounding.SUM:
        return found  # as `unit_rows` does, but in a tenth of the time
    unit: list[float] = unit_rows(np.array([found]))[0].tolist()
    return unit


FORMS: tuple[tuple[str, ...], ...] = (
    ('normal', 'velocity'),
    IN_DEGREES,  # all but the speed are 0 by default
    ('position', 'quaternion', 'speed'),
)


def read_strokes(path: Path, ball: tuple[float, float, float]) -> dict[str, Stroke]:
    """
    Read named strokes from a YAML file.

    Parameters
    ----------
    path : Path
        Of a list of mappings, each with the keys of one of `FORMS` and perhaps a `name`.
    ball : (3,) tuple of float
        Centre of the cue ball [m], for strokes that are stated as a pose.

    Raises
    ------
    ValueError
        Listing every mistake in the file.

    """
    data = read_yaml(path)
    if not isinstance(data, list) or not data:
        raise ValueError(f'{path} must hold a list of strokes, such as [{{a: 0.2, speed: 1.5}}]')
    strokes: dict[str, Stroke] = {}
    mistakes = []
    for number, item in enumerate(data, 1):
        name = str(item.get('name', number)) if isinstance(item, Mapping) else str(number)
        if name in strokes:
            mistakes.append(f'stroke {number}: name {name!r} is there twice')
        try:
            strokes[name] = stroke_from(item, ball)
        except ValueError as mistake:
            is_mapping = isinstance(item, Mapping)
            mistakes.append(f'stroke {name}{":" if is_mapping else ""} {mistake}')
    if mistakes:
        raise ValueError('\n  '.join([f'{path}: {len(mistakes)} wrong', *mistakes]))
    return strokes


def stroke_from(item: object, ball: tuple[float, float, float]) -> Stroke:
    """Make one stroke of a mapping with the keys of one of `FORMS`, and perhaps a `name`."""
    if not isinstance(item, Mapping):
        raise refused(item, 'a mapping')
    given: dict[str, Any] = {str(key): value for key, value in item.items() if key != 'name'}
    known = sorted({key for form in FORMS for key in form})
    for key in given:
        if key not in known:
            raise ValueError(f'{key} {unknown(key, known)}')
    if given.keys() == {'normal', 'velocity'}:
        return Stroke(**given)
    if given.keys() == {'position', 'quaternion', 'speed'}:
        return Stroke.from_pose(**given, ball=ball)
    if given and given.keys() <= set(FORMS[1]):
        return Stroke.from_offsets(**given)
    for form in (FORMS[0], FORMS[2]):
        if given and given.keys() <= set(form):
            raise ValueError(f'{next(key for key in form if key not in given)} is missing')
    raise ValueError(
        f'keys must be those of one form, {"; or ".join(", ".join(form) for form in FORMS)}, got '
        + ', '.join(given)
    )
