"""The impact of a cue with ball 0: its bodies, its contacts, and the record of its outcome."""

from billiard_shot.compiled import inner
from billiard_shot.impact.beginning import ContactProperties, UNLIMITED
from billiard_shot.impact.outcome import CollisionOutcome, ContactResult
from billiard_shot.impact.state import BodyState, TIP_BODY
from billiard_shot.numerics.frames import contact_axes
from billiard_shot.numerics.vectors import dot
from billiard_shot.records import Floats, Vector
from billiard_shot.status import INFINITE_SEQUENCE, MISCUE, OK
from billiard_shot.table.cue import CueParams, CueRecord, follow_through_time

# Contacts of an impact with the cue: tip and ball 0, ball 0 and cloth.
TIP_CONTACT, CLOTH_CONTACT = 0, 1
MAX_HITS = 8  # of a cue that follows: then it is taken away
UP = 0.0, 0.0, 1.0
# Slip at the end, relative to the cue's speed, that makes a miscue. Grip fades with the tip's
# pressure: while the cloth still pushes the ball, every tip slips in the last instant, in scene
# `pool` by up to 0.02 of the cue's speed. Genuine miscues end with more than 0.06.
MISCUE_SLIP = 0.03


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
    c.fading, c.decay, c.softening = 0.0, 0.0, 0.0
    c.keeps_normal, c.max_closings = False, UNLIMITED


@inner
def set_cloth(q: CueParams, c: ContactProperties) -> None:
    """Set the properties of a contact with the cloth, whose normal never turns."""
    c.friction, c.restitution = q.cloth_friction, q.cloth_restitution
    c.stiffness, c.keeps_normal = q.cloth_stiffness, True
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
    tip.friction, tip.restitution, tip.stiffness = q.friction, q.restitution, q.stiffness
    tip.max_closings = MAX_HITS if q.follows else 1
    set_cloth(q, cloth)
    contact_axes(n, axis, UP, axes, 0)
    for k in range(3):
        tip.tangent[k] = axes[1][k]
    contact_axes(UP, n, axis, axes, 0)
    for k in range(3):
        cloth.tangent[k] = axes[1][k]


@inner
def strike_status(status: int, miscue: bool) -> int:
    """Status of a strike: that of its impact, unless it went well and the tip still slides."""
    went_well = status in (OK, INFINITE_SEQUENCE)
    return MISCUE if went_well and miscue else status


@inner
def note_strike(
    cue: CueRecord,
    follows: bool,
    outcome: CollisionOutcome,
    tip: ContactResult,
    cloth: ContactResult,
    slip: float,
    body: BodyState,
) -> None:
    """
    Write the outcome of a strike into the record of its cue.

    Parameters
    ----------
    cue : CueRecord
        Before, its speed is that of the stroke.
    follows : bool
        Whether the cue goes on after its strike.
    outcome, tip, cloth : CollisionOutcome, ContactResult, ContactResult
        Of the impact.
    slip : float
        Of the tip when it left the ball [m/s].
    body : BodyState
        The tip at the end of the impact.

    """
    cue.status = strike_status(outcome.status, slip > MISCUE_SLIP * cue.speed)
    cue.phases, cue.steps = outcome.phases, outcome.steps
    cue.hits = max(tip.closings, 1)
    cue.discontinuity_margin = min(tip.discontinuity_margin, cloth.discontinuity_margin)
    cue.losses[0], cue.losses[1] = tip.restitution_loss, tip.friction_loss
    cue.losses[2], cue.losses[3] = cloth.restitution_loss, cloth.friction_loss
    cue.impulses[0], cue.impulses[1], cue.impulses[2] = tip.impulse, tip.impulse_1, tip.impulse_2
    cue.impulses[3], cue.impulses[4] = cloth.impulse, cloth.impulse_1
    cue.impulses[5] = cloth.impulse_2
    cue.speed = dot(cue.axis, body.velocity)
    cue.end = follow_through_time(cue.speed) if follows else 0.0
