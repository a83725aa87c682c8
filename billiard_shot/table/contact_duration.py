"""
How long two balls are in contact, and what that means for gaps between balls.

A spring F = k y^p stops two balls that meet at speed v at the depth y = (k_1 / k)^(1 / (p + 1)),
with k_1 = (p + 1) m v^2 / 4 for balls of mass m. The contact lasts C y / v: C is pi for a linear
spring and 2.943 after Hertz (Johnson, Contact Mechanics, section 11.4).
"""

from math import gamma, pi, sqrt

from billiard_shot.compiled import inner

DURATION_SPEED = 3.0  # m/s


def duration_constant(exponent: float) -> float:
    """Return the constant C of a spring's exponent."""
    x = 1.0 / (exponent + 1.0)
    return 2.0 * sqrt(pi) * gamma(1.0 + x) / gamma(0.5 + x)


def stiffness_of(mass: float, duration: float, exponent: float) -> float:
    """Stiffness [N/m^exponent] of balls whose contact at DURATION_SPEED has a duration [s]."""
    depth = DURATION_SPEED * duration / duration_constant(exponent)
    return 0.25 * (exponent + 1.0) * mass * DURATION_SPEED**2 / depth ** (exponent + 1.0)


@inner
def reach_of_impact(
    gap: float, duration: float, exponent: float, approach: float, along: float
) -> float:
    """
    Distance [m] up to which balls take part in the impact of two balls.

    A ball that touches another one goes as far while they do: along the line of centres half of
    what their approach gives, because they part at the same speeds exchanged; across it all.

    Parameters
    ----------
    gap : float
        Between bodies that touch [m].
    duration : float
        Of a contact at DURATION_SPEED [s].
    exponent : float
        Of the springs.
    approach, along : float
        Speed at which the balls meet; the larger one of their speeds across that direction [m/s].

    """
    if duration == 0.0:
        return gap
    slower = (DURATION_SPEED / approach) ** ((exponent - 1.0) / (exponent + 1.0))
    speed = sqrt((0.5 * approach) ** 2 + along * along)
    return max(gap, speed * duration * slower)
