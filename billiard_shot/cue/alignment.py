"""How the mechanism stands at the table: where its tip is, beside where its encoders say it is."""

from __future__ import annotations

from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array
from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import number
from billiard_shot.shot.stroke_vectors import axes

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
class Alignment:
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

    def __post_init__(self) -> None:
        check(self)

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
