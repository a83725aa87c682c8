"""
The incline that raises the back of the cue: actuator length to elevation, and back.

The pivot and the foot and head of the actuator are the corners of a triangle. Two sides are fixed:
the base (pivot to foot) and the arm (pivot to head). The third side is the actuator. The angle
opposite the actuator is the elevation plus a fixed angle.
"""

from dataclasses import dataclass
import math

from billiard_shot.cue.limits import check_range, raise_violations
from billiard_shot.scene.checks import check
from billiard_shot.scene.fields import number


@dataclass(frozen=True, slots=True)
class Incline:
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

    def __post_init__(self) -> None:
        check(self)

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
