"""
How long two bodies are in contact, and what that means for gaps between balls.

A spring F = k y^p stops two balls that meet at speed v at the depth y = (k_1 / k)^(1 / (p + 1)),
with k_1 = (p + 1) m v^2 / 4 for balls of mass m. The contact lasts C y / v: C is pi for a linear
spring and 2.943 after Hertz (Johnson, Contact Mechanics, section 11.4). Under law `bistiffness`
the spring opens 1 / e times as fast as it closed, so that with a restitution e the contact lasts
(1 + e) / 2 of that time.
"""

from math import gamma, pi, sqrt

from billiard_shot.compiled import inner

DURATION_SPEED = 3.0  # m/s, of the contacts of balls and cushions
STROKE_SPEED = 2.0  # m/s, of those of a struck ball with tip and cloth


def duration_constant(exponent: float) -> float:
    """Return the constant C of a spring's exponent."""
    x = 1.0 / (exponent + 1.0)
    return 2.0 * sqrt(pi) * gamma(1.0 + x) / gamma(0.5 + x)


def stiffness_of(
    mass: float,
    duration: float,
    exponent: float,
    speed: float = DURATION_SPEED,
    restitution: float = 1.0,
) -> float:
    """
    Stiffness of two balls whose contact has a duration [N/m^exponent].

    Parameters
    ----------
    mass : float
        Of each ball [kg]: twice the effective mass of two bodies.
    duration : float
        From touch to parting [s].
    exponent : float
        Of the spring.
    speed : float
        At which they meet [m/s].
    restitution : float

    """
    depth = speed * 2.0 * duration / (1.0 + restitution) / duration_constant(exponent)
    return 0.25 * (exponent + 1.0) * mass * speed**2 / depth ** (exponent + 1.0)


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
