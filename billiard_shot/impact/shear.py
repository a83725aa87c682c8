"""
The shear of a contact: a tangential spring beside the normal one, as of a leather tip.

Compression y and shear u store the energy E = k / (p + 1) q^((p + 1) / 2) with q = y^2 + r u^2,
for the stiffness k and the exponent p of the normal spring, and the ratio r of the tangential one:

    N = dE/dy = k y q^((p - 1) / 2)    F = -dE/du = -r k u q^((p - 1) / 2)

For elastic bodies of one material r is 2 (1 - nu) / (2 - nu) (Mindlin, J. Appl. Mech. 16, 1949).
Coulomb's cone |F| <= mu N is r |u| <= mu y, whatever the force is. A contact grips inside of it:
u' = slip. On it the contact drags along the direction d of u: u = (mu / r) y d, and the slip
is u' + s d with the sliding speed s = slip.d - (mu / r) y' >= 0. Then u' = slip - s d turns d.

If y is zero, so is u: the spring keeps no energy. Friction takes the energy mu N s alone.
"""

from math import sqrt

from billiard_shot.compiled import inner
from billiard_shot.impact.laws import elastic_energy
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.impact.state import (
    ContactState,
    DRAG,
    force_is_negligible,
    FRICTIONLESS,
    GRIP,
    RESTITUTION,
    shears,
    slip_speed,
)
from billiard_shot.numerics.polynomial import product_integral

STRAIGHT, FOLLOWS, TURNS = range(3)  # what the direction of a contact that drags does in a step


@inner
def begin_shear(c: ContactState) -> None:
    """Let a contact that has just closed grip or drag, by the ratio of its slip and approach."""
    if c.friction_mode == FRICTIONLESS:
        slip = slip_speed(c)
        c.friction_mode = GRIP
        if c.shear * slip > c.friction * max(-c.velocity[0], 0.0):
            c.friction_mode = DRAG
            c.slip_dir_1, c.slip_dir_2 = c.slip_1[0] / slip, c.slip_2[0] / slip


@inner
def begin_drag(c: ContactState) -> None:
    """Let a contact whose force has reached the cone drag along its shear."""
    c.friction_mode = DRAG
    hold_to_cone(c, TURNS)


@inner
def cone_width(c: ContactState) -> float:
    """Shear on the cone relative to the compression."""
    return c.friction / c.shear


@inner
def turning_of(planar: bool, c: ContactState) -> int:
    """
    How the direction of a contact that drags turns in the step from now: one of the three above.

    It follows a fast slip within the time |u| / slip. While that is too short for explicit steps,
    it is the direction of the slip.
    """
    slip = slip_speed(c)
    along = c.slip_1[0] * c.slip_dir_1 + c.slip_2[0] * c.slip_dir_2
    fast = cone_width(c) * c.compression[0] < METHOD_OPTIONS.least_lag * slip
    if planar:
        return STRAIGHT
    if fast and along > METHOD_OPTIONS.aligned * slip:
        return FOLLOWS
    return STRAIGHT if force_is_negligible(c) else TURNS


@inner
def hold_to_cone(c: ContactState, turning: int) -> None:
    """Put the shear of a contact that drags onto the cone, along its direction now."""
    d_1, d_2 = (c.shift_1[0], c.shift_2[0]) if turning == TURNS else (c.slip_1[0], c.slip_2[0])
    size = sqrt(d_1 * d_1 + d_2 * d_2)
    if turning != STRAIGHT and size > 0.0:
        c.slip_dir_1, c.slip_dir_2 = d_1 / size, d_2 / size
    rim = cone_width(c) * c.compression[0]
    c.shift_1[0], c.shift_2[0] = rim * c.slip_dir_1, rim * c.slip_dir_2


@inner
def shear_force(c: ContactState, y: float, u_1: float, u_2: float) -> tuple[float, float, float]:
    """Force on body a, along the normal and the tangents, at a compression and a shear."""
    square = y * y + c.shear * (u_1 * u_1 + u_2 * u_2)
    firmness = c.stiffness * square ** (0.5 * (c.exponent - 1.0))
    return firmness * y, -c.shear * firmness * u_1, -c.shear * firmness * u_2


@inner
def present_force(c: ContactState, loaded: bool) -> tuple[float, float, float]:
    """Force on body a now or, if no spring is loaded yet, one along the first force."""
    if loaded:
        return shear_force(c, c.compression[0], c.shift_1[0], c.shift_2[0])
    approach = max(-c.velocity[0], 0.0)
    if c.friction_mode == DRAG:
        rim = cone_width(c) * approach
        return shear_force(c, approach, rim * c.slip_dir_1, rim * c.slip_dir_2)
    return shear_force(c, approach, c.slip_1[0], c.slip_2[0])


@inner
def drag_stiffness(c: ContactState) -> float:
    """Stiffness k of the normal force k y^p of a contact that drags."""
    square = 1.0 + c.friction * cone_width(c)
    return c.stiffness * square ** (0.5 * (c.exponent - 1.0))


@inner
def spring_energy(c: ContactState) -> float:
    """Energy in the springs of a contact; zero if it is open."""
    y = c.compression[0]
    if shears(c):
        u_1, u_2 = c.shift_1[0], c.shift_2[0]
        y = sqrt(y * y + c.shear * (u_1 * u_1 + u_2 * u_2))
    return elastic_energy(c.stiffness, y, c.exponent)


@inner
def count_losses(c: ContactState, scale: float, order: int, x: float) -> None:
    """Add the energy that a step to x costs a contact that shears."""
    if c.normal_mode == RESTITUTION:
        faster = scale * (c.compression_rate - 1.0)
        c.restitution_loss += faster * product_integral(c.force, c.velocity, order, x)
    if c.friction_mode == DRAG:
        c.friction_loss += scale * c.friction * product_integral(c.force, c.sliding, order, x)
