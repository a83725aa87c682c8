"""A cue that strikes ball 0 of a table, or follows its stroke and may hit the ball again."""

from math import inf
from typing import Annotated, Any, NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact.beginning import UNLIMITED
from billiard_shot.impact.state import BodyState, ContactProperties, TIP_BODY
from billiard_shot.numerics.vectors import contact_axes
from billiard_shot.records import Floats, record, Vector, Vector3

THE_CUE = -3  # in place of the index of a ball; see also NOTHING and IMPACT
LONGEST_SWING = 6e-3  # s, of the end of a cue after tip and ball parted: then it is at rest
# m/s, of a cue after the strike. A slower one is braked by the same force over a shorter way: with
# 2 m/s^2 from 0.15 m on. An arm that swings like a pendulum brakes a cue as it accelerated it.
BRAKED_SPEED = 0.8
# A tip chatters if it touches the ball again so soon after it touched it first [s], while the ball
# is lower above the cloth than this [m]. Nobody can tell it from a strike with one hit.
CHATTER_TIME, CHATTER_HEIGHT = 5e-3, 1e-3


class CueParams(NamedTuple):
    """
    What an impact with the cue depends on.

    Stiffnesses are in N/m^exponent if bodies move during the impact; else only ratios matter.
    """

    response: float  # 1/kg, of the tip along the axis of the cue: 1 / mass of the cue
    across: float  # 1/kg, across the axis: 1 / mass of the end of the cue
    reach: float  # m, between the centres of tip and ball as they touch
    friction: float  # of tip and ball, like the next three
    restitution: float
    stiffness: float
    exponent: float
    cloth_friction: float
    cloth_restitution: float
    cloth_stiffness: float
    cloth_exponent: float
    ball_stiffness: float  # of two balls
    nose_stiffness: float  # of a cushion
    neighbour_reach: float  # m: balls and cushions at so small distances take part
    tip_duration: float  # s, of a central hit
    interval: float  # s, after which pressed contacts take their normals anew
    on_cloth: bool  # whether the cloth under ball 0 takes part
    moves: bool  # whether bodies move during the impact
    # m, that the cue goes on after the strike, and may hit the ball again; 0: it does not
    follow_through: float
    # Spring [N/m] and dashpot [kg/s] that hold the end to the axis; 0: it swings back at once.
    end_stiffness: float = 0.0
    end_damping: float = 0.0
    # Stiffness of the tip along its surface relative to that along the normal; 0: infinite.
    shear: float = 0.0


NO_CUE = CueParams(
    *(0.0,) * 4, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, inf, True, False, 0.0
)


@record
class CueRecord:
    """
    The cue of a table, and what its strike did to ball 0. Frame `table`.

    If it strikes, it touches ball 0 at time 0, and their impact comes first (strike.py): it writes
    tip, speed and end, and the fields from `strikes` on. All but the status are zero if the stroke
    was refused.
    """

    tip: Vector3  # m, centre of the sphere of its tip at time 0
    axis: Vector3  # unit vector along the stroke
    speed: float  # m/s along the axis; below 0 if it recoils
    end: float  # s, until when it follows
    normal: Vector3  # unit vector from the centre of ball 0 to where the tip strikes it
    tolerance: float  # of the strike, relative to the speed
    drift: float  # m/s, estimate how fast the ball's trajectory departs from the exact one
    strikes: bool
    # Whether other balls or cushions are so near that they may take part in the strike; afterwards
    # whether they did.
    others: bool
    status: int  # Status: that of the impact, or why the stroke was refused
    miscue: bool  # the tip slid on the ball, see strike.py
    velocity: Vector3  # m/s, of ball 0 at the end of the strike
    spin: Vector3  # rad/s
    hits: int  # how often the tip met the ball; 0: the table cannot begin
    chatter: bool  # the tip met the ball again, but too soon for a second hit, see `chatters`
    double_hit: float  # s, when the cue first hit the ball again; 0: in the strike; inf: never
    tip_time: float  # s, for how long the tip touched the ball in the strike
    cloth_time: float  # s, for how long the ball pressed the cloth in the strike
    contacts: int  # of the impact, closed or not: those of tip and cloth come first
    impulses: Annotated[Any, 6]  # N s, on the cue and from the cloth on the ball: x, y, z each
    losses: Annotated[Any, 4]  # J: tip restitution, tip friction; the same of the cloth
    discontinuity_margin: float  # see `ContactResult`; the least of tip and cloth
    phases: int
    steps: int


@inner
def chatters(time: float, height: float) -> bool:
    """
    Whether a tip that meets the ball again, which touched only the cloth meanwhile, chatters.

    Parameters
    ----------
    time : float
        Since the tip met the ball first [s].
    height : float
        Of the ball above the cloth [m].

    """
    return time < CHATTER_TIME and height < CHATTER_HEIGHT


@inner
def follow_through_time(distance: float, speed: float) -> float:
    """
    Find for how long a cue goes on, or recoils [s].

    Parameters
    ----------
    distance : float
        That it goes at `BRAKED_SPEED` or faster [m]. A force that brakes it by a distance takes
        the energy force * distance, so the distance falls with the square of the speed below.
    speed : float
        After the strike [m/s].

    """
    return distance * abs(speed) / max(abs(speed), BRAKED_SPEED) ** 2


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
