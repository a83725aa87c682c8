"""The impact of a cue with ball 0: its bodies and its contacts."""

from billiard_shot.compiled import inner
from billiard_shot.impact.beginning import ContactProperties, UNLIMITED
from billiard_shot.impact.state import BodyState, TIP_BODY
from billiard_shot.numerics.frames import contact_axes
from billiard_shot.records import Floats, Vector
from billiard_shot.table.cue import CueParams

# Contacts of an impact with the cue: tip and ball 0, ball 0 and cloth. The shaft comes last.
TIP_CONTACT, CLOTH_CONTACT = 0, 1
MAX_HITS = 8  # of a cue that follows: then it is taken away
UP = 0.0, 0.0, 1.0


@inner
def write_fixed(body: BodyState, kind: int, x: float, y: float, z: float) -> None:
    """Write a fixed body whose axis is (x, y, z)."""
    body.kind, body.response, body.across, body.turning = kind, 0.0, 0.0, 0.0
    body.axis[0], body.axis[1], body.axis[2] = x, y, z
    for k in range(3):
        body.position[k] = body.velocity[k] = body.spin[k] = 0.0


@inner
def write_tip(q: CueParams, axis: Vector, speed: float, tip: BodyState) -> None:
    """Write the tip of a cue as a body, but for its position."""
    write_fixed(tip, TIP_BODY, axis[0], axis[1], axis[2])
    tip.response, tip.across = q.response, q.across
    for k in range(3):
        tip.velocity[k] = speed * axis[k]


@inner
def write_contact(c: ContactProperties, a: int, b: int, gap: float) -> None:
    """Write a contact of bodies a and b at a distance [m], with the vertical as its tangent."""
    c.body_a, c.body_b, c.gap = a, b, gap
    c.tangent[0], c.tangent[1], c.tangent[2] = UP
    c.fading, c.decay, c.early_softening, c.softening, c.shear = 0.0, 0.0, 0.0, 0.0, 0.0
    c.keeps_normal, c.max_closings, c.is_shaft = False, UNLIMITED, False


@inner
def shafts_of(q: CueParams) -> int:
    """Return the number of contacts that are shafts: 1, or 0 if the end of the cue is free."""
    return 1 if q.end_stiffness > 0.0 or q.end_damping > 0.0 else 0


@inner
def write_shaft(
    q: CueParams, axis: Vector, n: Vector, tip: int, cloth: int, c: ContactProperties, axes: Floats
) -> None:
    """
    Write the shaft of a cue.

    Parameters
    ----------
    q : CueParams
    axis, n : (3,) floats
        As of `set_tip_and_cloth`. If these and the vertical are in one plane, so is the first
        tangent.
    tip, cloth : int
        The bodies; the shaft does not move the cloth.
    c : ContactProperties
        Written.
    axes : (3, 3) floats
        Scratch.

    """
    write_contact(c, tip, cloth, 0.0)
    c.friction, c.restitution, c.stiffness, c.exponent = 0.0, 0.0, 0.0, 1.0
    c.is_shaft, c.keeps_normal = True, True
    c.spring, c.damping = q.end_stiffness, q.end_damping
    contact_axes(axis, n, UP, axes, 0)
    for k in range(3):
        c.tangent[k] = axes[1][k]


@inner
def set_cloth(q: CueParams, c: ContactProperties) -> None:
    """Set the properties of a contact with the cloth, whose normal never turns."""
    c.friction, c.restitution = q.cloth_friction, q.cloth_restitution
    c.stiffness, c.exponent, c.keeps_normal = q.cloth_stiffness, q.cloth_exponent, True
    c.max_closings = UNLIMITED if q.on_cloth else 0


@inner
def set_tip_and_cloth(
    q: CueParams,
    axis: Vector,
    n: Vector,
    tip: ContactProperties,
    cloth: ContactProperties,
    axes: Floats,
) -> None:
    """
    Set the properties of the contacts of tip and cloth, but for their bodies and gaps.

    The tip's first tangent points along its slip. If axis, normal and vertical are in one plane,
    so are both first tangents, and nothing couples to the second ones.

    Parameters
    ----------
    q : CueParams
    axis, n : (3,) floats
        Unit vectors: along the stroke, and from the centre of ball 0 to the tip.
    tip, cloth : ContactProperties
        Written.
    axes : (3, 3) floats
        Scratch.

    """
    tip.friction, tip.restitution = q.friction, q.restitution
    tip.stiffness, tip.exponent, tip.shear = q.stiffness, q.exponent, q.shear
    tip.max_closings = MAX_HITS if q.follow_through > 0.0 else 1
    set_cloth(q, cloth)
    contact_axes(n, axis, UP, axes, 0)
    for k in range(3):
        tip.tangent[k] = axes[1][k]
    contact_axes(UP, n, axis, axes, 0)
    for k in range(3):
        cloth.tangent[k] = axes[1][k]
