"""Who plays: what a robot can do, and how exactly it does it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import number
from billiard_shot.scene.mistakes import Mistake


def _limits_in_order(robot: Any) -> Iterator[Mistake]:
    for name, unit in (('speed', 'm/s'), ('elevation', 'degrees')):
        suffix = '_deg' if unit == 'degrees' else ''
        least, most = f'{name}_min{suffix}', f'{name}_max{suffix}'
        if getattr(robot, least) > getattr(robot, most):
            yield Mistake(
                (most,),
                (
                    f'{getattr(robot, most):g} is not allowed; it must be at least {least}, '
                    f'{getattr(robot, least):g} ({unit})'
                ),
            )


@dataclass(frozen=True, slots=True)
class Robot:
    """
    What strokes a player can play.

    Parameters
    ----------
    speed_min, speed_max : float
        Of the cue [m/s], above 0. Up to 4.5: the computer pool tournaments (FastFiz).
    elevation_min_deg, elevation_max_deg : float
        0 to 90 degrees.
    azimuth_deg, azimuth_range_deg : float
        The middle of the directions in which it can strike, counter-clockwise from +x, and how far
        to each side they reach: by default 180, all around.
    offset_max : float
        Largest distance of the tip from the middle of the ball, in ball radii, above 0 and below
        1. 0.5: where tips begin to slip in play (half the radius; Alciatore, miscue limit).

    """

    RULES: ClassVar = (_limits_in_order,)
    speed_min: float = number('m/s', above=0, default=0.1)
    speed_max: float = number('m/s', above=0, default=4.5)
    elevation_min_deg: float = number('degrees', least=0, most=90, default=0.0)
    elevation_max_deg: float = number('degrees', least=0, most=90, default=85.0)
    azimuth_deg: float = number('degrees', least=-360, most=360, default=0.0)
    azimuth_range_deg: float = number('degrees', least=0, most=180, default=180.0)
    offset_max: float = number('ball radii', above=0, most=0.99, default=0.5)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, slots=True)
class Noise:
    """
    How much strokes differ from what was planned: standard deviations of independent errors.

    The defaults are those of the computer pool tournaments (FastFiz, Noise.h).

    Parameters
    ----------
    a, b : float
        Of where the tip hits, to the right and up [m], at least 0.
    elevation_deg, azimuth_deg : float
        [degrees], at least 0.
    speed : float
        [m/s], at least 0.

    """

    a: float = number('m', least=0, default=0.0005)
    b: float = number('m', least=0, default=0.0005)
    elevation_deg: float = number('degrees', least=0, default=0.1)
    azimuth_deg: float = number('degrees', least=0, default=0.125)
    speed: float = number('m/s', least=0, default=0.075)

    def __post_init__(self) -> None:
        check(self)

    def times(self, factor: float) -> Noise:
        """Noise that is larger by a factor, at least 0."""
        return Noise(
            factor * self.a,
            factor * self.b,
            factor * self.elevation_deg,
            factor * self.azimuth_deg,
            factor * self.speed,
        )
