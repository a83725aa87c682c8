"""
The incline that raises the back of the cue: actuator length to elevation, and back.

The pivot and the foot and head of the actuator are the corners of a triangle. Two sides are fixed:
the base (pivot to foot) and the arm (pivot to head). The third side is the actuator. The angle
opposite the actuator is the elevation plus a fixed angle.
"""

from collections.abc import Iterator
from dataclasses import dataclass
import math
from typing import Any, ClassVar

from billiard_shot.cue.limits import check_range, raise_violations
from billiard_shot.scene.checks import check
from billiard_shot.scene.errors import Mistake
from billiard_shot.scene.fields import number


def _lengths_of_a_triangle(incline: Any) -> Iterator[Mistake]:
    low, high = abs(incline.base - incline.arm), incline.base + incline.arm
    # At these lengths the triangle is flat, and the actuator cannot turn the incline.
    if not low < incline.shortest < incline.longest < high:
        yield Mistake(
            ('shortest',),
            (
                f'and longest must ascend, between {low:g} and {high:g}, where the triangle is '
                f'flat, got {incline.shortest:g} and {incline.longest:g} (m)'
            ),
        )


@dataclass(frozen=True, slots=True)
class Incline:
    """
    The triangle of the incline, and the range of the actuator's length.

    Parameters
    ----------
    base, arm : float
        Distances from the pivot to the foot and to the head of the actuator [m], above 0.
    level_angle : float
        Angle between base and arm when the cue is level [rad], above 0.
    shortest, longest : float
        Length of the retracted and of the extended actuator [m].

    """

    RULES: ClassVar = (_lengths_of_a_triangle,)
    base: float = number('m', above=0, default=0.5)
    arm: float = number('m', above=0, default=0.3)
    level_angle: float = number('rad', above=0, maximum=math.pi, default=1.0)
    shortest: float = number('m', above=0, default=0.40)
    longest: float = number('m', above=0, default=0.72)

    def __post_init__(self) -> None:
        check(self)

    def length(self, elevation: float) -> float:
        """
        Length of the actuator [m] for an elevation [rad].

        This is the law of cosines as a sum of squares, which is accurate at small angles too.

        Raises
        ------
        LimitError
            If the actuator cannot have this length.

        """
        angle = elevation + self.level_angle
        raise_violations(
            check_range('elevation', angle, 0.0, math.pi, 'rad', 'angle of the triangle')
        )
        half_chord = math.sqrt(self.base * self.arm) * math.sin(angle / 2)
        length = math.hypot(self.base - self.arm, 2 * half_chord)
        raise_violations(
            check_range(
                'incline',
                length,
                self.shortest,
                self.longest,
                'm',
                f'elevation {elevation:.4g} rad',
            )
        )
        return length

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
