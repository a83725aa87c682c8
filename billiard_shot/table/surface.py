"""Numbers that the motion on the table depends on, in the form that compiled code takes."""
from typing import NamedTuple

AUTO, ON, OFF = 0, 1, 2


class Surface(NamedTuple):
    """A ball and the cloth it is on."""

    mass: float  # kg
    radius: float  # m
    inertia: float  # kg m^2
    gravity: float  # m/s^2
    sliding: float  # coefficient of friction while it slides; inf: it rolls at once
    rolling: float  # deceleration while it rolls, in units of gravity
    spin_deceleration: float  # of the spin about the vertical, rad/s^2
    restitution: float  # of a bounce
    friction: float  # of a bounce
    stiffness: float  # of the cloth's virtual spring, like the next two for clusters of bodies
    law: int  # of impacts, see billiard_shot.impact.laws
    exponent: float  # of the springs
    flight: int  # AUTO, ON or OFF
    bounce: int = AUTO  # or ON; off is a restitution of 0
