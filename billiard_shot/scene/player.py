"""The player: limits of its strokes, and its execution noise."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
import math
from typing import Any, ClassVar, Protocol, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.numerics.vectors import wrapped
from billiard_shot.scene.errors import Mistake
from billiard_shot.scene.fields import as_floats, CheckedRecord, number, positive, section, whole

A, B, ELEVATION, AZIMUTH, SPEED = range(5)  # columns of strokes
OFFSETS = 'a', 'b', 'elevation', 'azimuth', 'speed'  # names of these columns
IN_DEGREES = 'a', 'b', 'elevation_deg', 'azimuth_deg', 'speed'  # the same in files and records
DEVIATIONS = *IN_DEGREES, 'balls'  # of `Noise`
POOL_BALL_RADIUS = 0.028575  # m: 2 1/4 inches across
MIN_NOISY_SPEED = 1e-3  # m/s, of a stroke with errors


def offset_columns(strokes: ArrayLike) -> dict[str, NDArray[np.float64]]:
    """Return n strokes (n, 5), in radians, as columns by the names of `IN_DEGREES`."""
    columns = np.array(strokes, float).reshape(-1, len(OFFSETS)).T
    columns[[ELEVATION, AZIMUTH]] = np.degrees(columns[[ELEVATION, AZIMUTH]])
    return dict(zip(IN_DEGREES, columns, strict=True))


class StrokeOffsets(Protocol):
    """A stroke; see `billiard_shot.Stroke`, which is above this layer."""

    @property
    def axis(self) -> bool:
        """Return whether the offsets are those of the axis of the cue."""

    @property
    def offsets(self) -> tuple[float, float, float, float, float]:
        """Return the arguments of `from_offsets`."""

    @classmethod
    def from_offsets(
        cls, a: float, b: float, elevation: float, azimuth: float, speed: float, *, axis: bool
    ) -> Self:
        """Make a stroke."""


S = TypeVar('S', bound=StrokeOffsets)


def _limits_in_order(robot: Any) -> Iterator[Mistake]:
    for name, unit in (('speed', 'm/s'), ('elevation', 'degrees')):
        suffix = '_deg' if unit == 'degrees' else ''
        low, high = f'{name}_min{suffix}', f'{name}_max{suffix}'
        if getattr(robot, low) > getattr(robot, high):
            yield Mistake(
                (high,),
                (
                    f'must be at least {low}, {getattr(robot, low):g}, got '
                    f'{getattr(robot, high):g} ({unit})'
                ),
            )


@dataclass(frozen=True, slots=True)
class Robot(CheckedRecord):
    """
    Limits of the strokes of a player.

    Parameters
    ----------
    speed_min, speed_max : float
        Limits of the cue speed [m/s], above 0. Up to 4.5: the computer pool tournaments (FastFiz).
    elevation_min_deg, elevation_max_deg : float
        Limits of the elevation [degrees], 0 to 90.
    azimuth_deg, azimuth_half_range_deg : float
        Middle of the allowed azimuths, counter-clockwise from +x, and half the width of their
        range [degrees]; by default 180, all directions.
    offset_max : float
        Largest distance of the tip from the middle of the ball, in ball radii, above 0 and below
        1. 0.5: where tips begin to slip in play (half the radius; Alciatore, miscue limit).

    """

    RULES: ClassVar = (_limits_in_order,)
    speed_min: float = number('m/s', above=0, default=0.1)
    speed_max: float = number('m/s', above=0, default=4.5)
    elevation_min_deg: float = number('degrees', minimum=0, maximum=90, default=0.0)
    elevation_max_deg: float = number('degrees', minimum=0, maximum=90, default=85.0)
    azimuth_deg: float = number('degrees', minimum=-360, maximum=360, default=0.0)
    azimuth_half_range_deg: float = number('degrees', minimum=0, maximum=180, default=180.0)
    offset_max: float = number('ball radii', above=0, maximum=0.99, default=0.5)


@dataclass(frozen=True, slots=True)
class Bias(CheckedRecord):
    """
    Mean errors of a player: what its strokes have more than it was told to play.

    Parameters
    ----------
    a, b : float
        Of the contact point of the tip, to the right and up [m], -0.1 to 0.1.
    elevation_deg, azimuth_deg : float
        [degrees], -90 to 90.
    speed : float
        [m/s].

    """

    a: float = number('m', minimum=-0.1, maximum=0.1, default=0.0)
    b: float = number('m', minimum=-0.1, maximum=0.1, default=0.0)
    elevation_deg: float = number('degrees', minimum=-90, maximum=90, default=0.0)
    azimuth_deg: float = number('degrees', minimum=-90, maximum=90, default=0.0)
    speed: float = number('m/s', default=0.0)


@dataclass(frozen=True, slots=True)
class Noise(CheckedRecord):
    """
    Execution noise of a player: standard deviations of independent errors, and their means.

    Planned strokes are the mean of the strokes that are executed. `commanded` says what to tell a
    player whose errors have another mean than 0.

    The defaults are those of the computer pool tournaments (FastFiz, Noise.h).

    Parameters
    ----------
    a, b : float
        Of the contact point of the tip, to the right and up [m], 0 to 0.1.
    elevation_deg, azimuth_deg : float
        [degrees], 0 to 90.
    speed : float
        [m/s], at least 0.
    balls : float
        Of the known places of the balls, in each direction [m], 0 to 0.1. Only plans use it.
    bias : Bias
        Mean errors, which `commanded` corrects.

    """

    a: float = number('m', minimum=0, maximum=0.1, default=0.0005)
    b: float = number('m', minimum=0, maximum=0.1, default=0.0005)
    elevation_deg: float = number('degrees', minimum=0, maximum=90, default=0.1)
    azimuth_deg: float = number('degrees', minimum=0, maximum=90, default=0.125)
    speed: float = number('m/s', minimum=0, default=0.075)
    balls: float = number('m', minimum=0, maximum=0.1, default=0.0)
    bias: Bias = section(Bias, optional=True)

    def perturb(
        self, stroke: S, rng: np.random.Generator, ball_radius: float = POOL_BALL_RADIUS
    ) -> S:
        """
        Draw a stroke as the player executes it.

        Parameters
        ----------
        stroke : Stroke
            As it is planned.
        rng : numpy.random.Generator
        ball_radius : float
            [m]; by default that of pool balls.

        Returns
        -------
        Stroke
            With independent normal errors. Its speed is at least 1 mm/s. If the stroke states the
            axis of the cue, the errors of a and b are those of the axis.

        """
        offsets = self.sample(stroke, 1, rng, ball_radius)[0].tolist()
        return type(stroke).from_offsets(*offsets, axis=stroke.axis)

    def sample(
        self,
        strokes: StrokeOffsets | ArrayLike,
        n: int,
        rng: np.random.Generator,
        ball_radius: float = POOL_BALL_RADIUS,
    ) -> NDArray[np.float64]:
        """
        Draw strokes as the player executes them, as arrays.

        Parameters
        ----------
        strokes : Stroke, or (5,) or (m, 5) array_like
            As planned: one stroke, or the arguments a, b, elevation, azimuth, speed of
            `Stroke.from_offsets`, of one or many.
        n : int
            How often each stroke is executed, at least 1.
        rng : numpy.random.Generator
        ball_radius : float
            [m]; by default that of pool balls.

        Returns
        -------
        (n, 5) or (m, n, 5) float array
            As `perturb` executes them, for `predict_batch`; every stroke has errors of its own.

        Raises
        ------
        ValueError
            If an argument makes no sense.

        """
        n, sigmas = whole('n', n, 1), self.sigmas(ball_radius)
        planned = as_floats(getattr(strokes, 'offsets', strokes))
        if planned.ndim not in (1, 2) or planned.shape[-1] != 5:
            raise ValueError(f'strokes must be of shape (5,) or (m, 5), got {planned.shape}')
        played = planned[..., np.newaxis, :] + sigmas * rng.standard_normal(
            (*planned.shape[:-1], n, 5)
        )
        # Beyond the vertical the cue comes from the other side.
        over = played[..., ELEVATION] > 0.5 * math.pi
        played[over, A] *= -1.0
        played[over, B] *= -1.0
        played[over, ELEVATION] = math.pi - played[over, ELEVATION]
        played[over, AZIMUTH] = wrapped(played[over, AZIMUTH] + math.pi)
        played[..., SPEED] = np.maximum(played[..., SPEED], MIN_NOISY_SPEED)
        return played

    def sigmas(self, ball_radius: float = POOL_BALL_RADIUS) -> NDArray[np.float64]:
        """Return the standard deviations (5,) of a, b (ball radii), angles (rad), speed (m/s)."""
        return _in_columns(self, ball_radius)

    def means(self, ball_radius: float = POOL_BALL_RADIUS) -> NDArray[np.float64]:
        """Return the mean errors (5,) in the same units."""
        return _in_columns(self.bias, ball_radius)

    def commanded(self, stroke: S, ball_radius: float = POOL_BALL_RADIUS) -> S:
        """
        Correct the bias: return the stroke to command, so that a planned one is played on average.

        Parameters
        ----------
        stroke : Stroke
            As it is planned.
        ball_radius : float
            [m]; by default that of pool balls.

        Returns
        -------
        Stroke
            The same one if there is no bias. Elevations are at least 0, and speeds 1 mm/s.

        """
        bias = self.means(ball_radius)
        if not bias.any():
            return stroke
        offsets = with_errors(np.array(stroke.offsets), -bias).tolist()
        return type(stroke).from_offsets(*offsets, axis=stroke.axis)

    def times(self, factor: float) -> Noise:
        """Return the noise with all standard deviations multiplied by a factor, at least 0."""
        return replace(self, **{name: factor * getattr(self, name) for name in DEVIATIONS})

    def beside(self, other: ModelError) -> Noise:
        """Return the noise with independent errors added."""
        both: dict[str, Any] = {
            name: math.hypot(getattr(self, name), getattr(other, name)) for name in DEVIATIONS
        }
        return replace(self, **both)


@dataclass(frozen=True, slots=True)
class ModelError(CheckedRecord):
    """
    How far a scene that was fitted errs, as standard deviations of equivalent errors.

    Whoever states chances reckons with them beside the errors of the player, see
    `Scene.planned_noise`. A calibration writes them.

    Parameters
    ----------
    a, b, elevation_deg, azimuth_deg, speed, balls : float
        Of strikes and of places of balls, in the units and ranges of `Noise`.

    """

    a: float = number('m', minimum=0, maximum=0.1, default=0.0)
    b: float = number('m', minimum=0, maximum=0.1, default=0.0)
    elevation_deg: float = number('degrees', minimum=0, maximum=90, default=0.0)
    azimuth_deg: float = number('degrees', minimum=0, maximum=90, default=0.0)
    speed: float = number('m/s', minimum=0, default=0.0)
    balls: float = number('m', minimum=0, maximum=0.1, default=0.0)


LEVELS = {400: 3.6, 500: 2.2, 600: 1.5, 700: 1.05, 800: 0.72}
"""
Noise of people by their rating (FargoRate), as a multiple of the noise of tournaments.

With it the agent `player` runs out as often as they do: see docs/levels.md.
"""

NOISES = {
    'tournament': Noise(),
    'none': Noise(0.0, 0.0, 0.0, 0.0, 0.0),
    **{f'fargo_{rating}': Noise().times(factor) for rating, factor in LEVELS.items()},
}
"""Noise by names: of the computer pool tournaments, see `Noise`; none; and of `LEVELS`."""


def _in_columns(errors: Noise | Bias, ball_radius: float) -> NDArray[np.float64]:
    """Return the errors (5,) of a, b (ball radii), elevation, azimuth (rad), speed (m/s)."""
    ball_radius = positive('ball_radius', ball_radius, 'm')
    return np.array(
        [
            errors.a / ball_radius,
            errors.b / ball_radius,
            math.radians(errors.elevation_deg),
            math.radians(errors.azimuth_deg),
            errors.speed,
        ]
    )


def with_errors(strokes: NDArray[np.float64], errors: NDArray[np.float64]) -> NDArray[np.float64]:
    """
    Add errors to strokes, so that each can be played.

    Elevations are raised to 0, and speeds to 1 mm/s.

    Parameters
    ----------
    strokes, errors : (..., 5) float arrays
        a, b (ball radii), elevation, azimuth (rad), speed (m/s).

    """
    played = strokes + errors
    played[..., ELEVATION] = np.maximum(played[..., ELEVATION], 0.0)
    played[..., SPEED] = np.maximum(played[..., SPEED], MIN_NOISY_SPEED)
    return played
