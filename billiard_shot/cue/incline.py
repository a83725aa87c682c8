"""
The incline that raises the back of the cue: actuator length to elevation, and back.

Pivot, foot and head of the actuator are the corners of a triangle. Two of its sides are fixed, the
base (pivot to foot) and the arm (pivot to head); the actuator is the third, and the angle opposite
to it is the elevation plus a fixed one.
"""

from collections.abc import Iterator
from dataclasses import dataclass
import math
from typing import Any, ClassVar

from billiard_shot.cue.limits import outside, refuse
from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import number
from billiard_shot.scene.mistakes import Mistake


def _lengths_of_a_triangle(incline: Any) -> Iterator[Mistake]:
    least, most = abs(incline.base - incline.arm), incline.base + incline.arm
    # At the ends themselves the triangle is flat and the actuator could turn it neither way.
    if not least < incline.shortest < incline.longest < most:
        yield Mistake(
            ('shortest',),
            (
                f'{incline.shortest:g}, and longest {incline.longest:g}, is not allowed; they '
                f'must ascend, between {least:g} and {most:g}, where the triangle is flat (m)'
            ),
        )


@dataclass(frozen=True, slots=True)
class Incline:
    """
    The triangle of the incline, and how long its actuator can be.

    Parameters
    ----------
    base, arm : float
        From the pivot to the foot and to the head of the actuator [m], above 0.
    level_angle : float
        Angle at the pivot, between base and arm, where the cue is level [rad], above 0.
    shortest, longest : float
        Length of the actuator when it is in and out [m].

    """

    RULES: ClassVar = (_lengths_of_a_triangle,)
    base: float = number('m', above=0, default=0.5)
    arm: float = number('m', above=0, default=0.3)
    level_angle: float = number('rad', above=0, most=math.pi, default=1.0)
    shortest: float = number('m', above=0, default=0.40)
    longest: float = number('m', above=0, default=0.72)

    def __post_init__(self) -> None:
        check(self)

    def length(self, elevation: float) -> float:
        """
        Length of the actuator [m] that raises the cue to an elevation [rad].

        The law of cosines, as a sum of squares so that a small angle loses no digits.

        Raises
        ------
        LimitError
            If the actuator is not that short, or long.

        """
        angle = elevation + self.level_angle
        refuse(outside('elevation', angle, 0.0, math.pi, 'rad', 'angle of the triangle'))
        half_chord = math.sqrt(self.base * self.arm) * math.sin(angle / 2)
        length = math.hypot(self.base - self.arm, 2 * half_chord)
        refuse(
            outside(
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
        Elevation [rad] to which an actuator of this length [m] raises the cue.

        The half-angle form of the law of cosines: exact for flat triangles too (W. Kahan,
        "Miscalculating area and angles of a needle-like triangle", 2014).

        Raises
        ------
        LimitError
            If the sides do not make a triangle.

        """
        least, most = self.sides
        refuse(outside('incline', length, least, most, 'm', 'sides of the triangle'))
        short = math.sqrt((length - least) * (length + least))
        long = math.sqrt((most - length) * (most + length))
        return 2 * math.atan2(short, long) - self.level_angle

    def lever(self, elevation: float) -> float:
        """How much longer the actuator gets per elevation [m/rad], at an elevation [rad]."""
        sine = math.sin(elevation + self.level_angle)
        return self.base * self.arm * sine / self.length(elevation)

    @property
    def sides(self) -> tuple[float, float]:
        """Lengths of the actuator at which the triangle is flat [m]; it must be in between."""
        return abs(self.base - self.arm), self.base + self.arm

    @property
    def elevations(self) -> tuple[float, float]:
        """Elevations [rad] between which the actuator can raise the cue."""
        return self.elevation(self.shortest), self.elevation(self.longest)
