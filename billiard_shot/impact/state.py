"""The state of a collision: a record for each contact, and the matrices that couple them."""

from enum import IntEnum
from math import exp, inf, sqrt
from typing import Annotated, Any, NamedTuple

import numpy as np

from billiard_shot.compiled import inner
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.records import Floats, record, Storage, Vector3

MAX_COEFFICIENTS = 26  # of a step's polynomials
IMPLICIT_STAGES = 8  # of an implicit step
HISTORY = 15  # sections of a sequence that are kept, see kernel.py
SECTION = 10  # numbers that a section has for each contact

Series = Annotated[Any, MAX_COEFFICIENTS]
Nodes = Annotated[Any, IMPLICIT_STAGES]


class NormalMode(IntEnum):
    """Mode of the spring of a contact."""

    INACTIVE = 0
    COMPRESSION = 1
    RESTITUTION = 2
    SHAFT = 3  # it is the shaft of a cue, which has no normal force (integrator.py)


class FrictionMode(IntEnum):
    """
    How a contact resists slip.

    An inactive contact is FRICTIONLESS. An active one can be in any mode, in compression and in
    restitution alike.
    """

    FRICTIONLESS = 0
    DEFERRED = 1  # no friction yet: the normal force is too small to set the slip direction
    STICK = 2
    REDUNDANT_STICK = 3  # its own share of friction is beyond its cone; other contacts hold it
    SLIP = 4
    SLIP_ONSET = 5  # the slip is exactly zero and about to grow along the slip direction
    CREEP = 6  # it slips so slowly that the forces set the slip direction: a stiff equation
    ELASTIC = 7  # a spring and a dashpot resist the slip
    GRIP = 8  # a spring beside the normal one takes the slip up (friction.py)
    DRAG = 9  # that spring is at the friction cone, and slides


class Hold(IntEnum):
    """Whether an open contact may close (moving_bodies.py)."""

    FREE = 0
    HELD = 1  # a ball holds the end of a cue aside: not before the tip is clear of the ball
    GONE = 2  # it closed as often as it may


class BodyKind(IntEnum):
    """Kind of a body that moves, or is fixed, while others do."""

    BALL = 0
    TIP = 1
    PLANE = 2
    EDGE = 3


INACTIVE, COMPRESSION, RESTITUTION, SHAFT = map(int, NormalMode)
(
    FRICTIONLESS, DEFERRED, STICK, REDUNDANT_STICK, SLIP, SLIP_ONSET, CREEP, ELASTIC, GRIP, DRAG,
) = map(int, FrictionMode)  # fmt: skip
FREE, HELD, GONE = map(int, Hold)
BALL_BODY, TIP_BODY, PLANE, EDGE = map(int, BodyKind)


@record
class ContactProperties:
    """A contact of a collision, before it begins."""

    # The coefficient of friction at slip v is friction - fading (1 - exp(-decay v)).
    friction: float
    fading: float
    decay: float  # s/m
    # The restitution at the energy E of the peak is
    # restitution / (1 + early_softening E^(1/2) + softening E).
    restitution: float
    early_softening: float  # 1/J^(1/2)
    softening: float  # 1/J
    stiffness: float  # N/m^exponent; see `Contact`
    exponent: float
    shear: float  # tangential stiffness relative to the normal one (friction.py); 0: rigid
    # Only if the bodies are given:
    body_a: int  # number of a ball or tip
    body_b: int  # number of a ball, plane or edge
    gap: float  # [m] between the bodies
    tangent: Vector3  # whose part normal to the normal is the first tangent
    keeps_normal: bool  # while it is pressed
    max_closings: int  # how often it may close; 0: never
    # If body a is a tip, and the contact is its shaft (integrator.py), which has a spring [N/m]
    # and a dashpot [kg/s] and none of the other properties:
    is_shaft: bool
    spring: float
    damping: float


class ContactLog:
    """Impulse, losses, ways and times of a contact until now: fields of its records."""

    impulse: Vector3  # on body a: along the normal, and along the tangents
    restitution_loss: float  # energy
    friction_loss: float
    final_slip: float  # when the contact ended last
    slid: float  # way that the bodies slipped until the contact ended first,
    slid_to_peak: float  # and the part of it before the largest compression
    began: float  # time since the beginning at which the contact became active last
    lifted: float  # largest distance of body b from its plane when the contact closed again
    touched: float  # time that it was active in all
    # Least margin of a decision between restitution and recompression, relative to the peak of
    # compression; infinite without a decision. Near 0, the result is close to a discontinuity.
    discontinuity_margin: float
    closings: int  # how often it became active


@record
class ContactState(ContactProperties, ContactLog):
    """
    A contact of a collision: properties, modes, the step's polynomials, results.

    The axes of a contact are its normal and two tangents, numbered 1 and 2. A polynomial is one in
    x = time / scale, lowest coefficient first: coefficient 0 is the value now. Units are those of
    `Options`, and stiffnesses are relative to that of the contact whose spring is fastest.
    """

    normal_mode: int
    friction_mode: int
    # Relative to the approach: y' = -rate u_n; 0 if y of an open contact stays 0.
    compression_rate: float
    peak_compression: float  # at which restitution began
    restitution_end: float  # compression (law poisson: impulse) that ends restitution
    lost_share: float  # of the energy that the spring releases in restitution
    activation_impulse: float  # normal impulse when the contact became active
    negligible_compression: float  # up to which the force is negligible
    slip_dir_1: float  # unit vector of the slip
    slip_dir_2: float
    # If the bodies are those of moving_bodies.py: the axes, the distance at which the contact
    # closes next, and that at which bodies touch that are not dented.
    is_tip: bool  # whether body a is the tip of a cue
    is_turned: bool  # it has the normal of the moment at which it was about to slip
    hold: int  # a `Hold`
    closing_distance: float
    reach: float
    normal: Vector3
    tangent_1: Vector3
    tangent_2: Vector3
    velocity: Series  # polynomials: normal velocity, slip,
    slip_1: Series
    slip_2: Series
    compression: Series  # below zero: minus the distance at an open contact
    force: Series  # on body a: normal force, friction
    friction_1: Series
    friction_2: Series
    shift_1: Series  # extension of the spring that resists slip
    shift_2: Series
    size: Series  # of the slip, and its direction; if the contact shears, along the shear
    dir_1: Series
    dir_2: Series
    coefficient: Series  # of friction, if slip lowers it; and the normal force times the direction
    press_1: Series
    press_2: Series
    sliding: Series  # speed at which a contact slides that shears; q of friction.py if it grips
    node_velocity: Nodes  # the same at the stages of an implicit step
    node_slip_1: Nodes
    node_slip_2: Nodes
    node_compression: Nodes
    angle: Nodes  # by which the slip has turned; its cosine and sine along the tangents
    cosine: Nodes
    sine: Nodes


@record
class ImpactProgress:
    """Progress of the integration of a collision."""

    status: int
    phases: int  # logged so far
    steps: int
    steps_since_event: int
    events: int
    section: int  # contact that sections are counted by, -1: none yet; see kernel.py
    section_start: int  # number of events when the section began
    sections: int  # recorded so far
    event_hash: int  # of the events in this section
    scale: float  # length of the next step
    speed: float  # largest velocity that a contact has, or that its spring could still give
    modes_changed: bool  # forces jumped: friction modes must be assigned again
    time: float  # since the start
    phase_open: bool  # the motion went on since the last phase was logged
    stiff: int  # contacts that needed an implicit step last
    next_turn: float  # time at which pressed contacts take their normals anew
    first_end: float  # time at which first no contact was active while an end swung
    energy: float  # kinetic, of bodies that move, when the collision began
    max_slid_to_peak: float  # this and the next three as of `TipLimits`
    max_slid: float
    max_again: float
    max_lifted: float


@record
class PhaseLog:
    """State of a contact at the end of a phase; N of these are one phase."""

    ending: int  # why the phase ended, an `Ending`
    contact: int  # contact at which it ended; -1 if the whole collision ended
    active: int
    # [N s] on body a since the start: along the normal, and along the tangents. If the bodies are
    # those of moving_bodies.py: along x, y and z.
    impulse: float
    impulse_1: float
    impulse_2: float
    energy: float  # [J] elastic


@record
class BodyState:
    """
    A ball, the tip of a cue, or a plane or an edge that is fixed.

    A fixed body has the responses zero. Its position is any point of it.
    """

    kind: int  # a `BodyKind`
    response: float  # 1 / mass [1/kg]; of a tip: along the axis of its cue
    across: float  # [1/kg] of a tip: across that axis; of a ball the same as `response`
    turning: float  # radius^2 / inertia of a ball [1/kg]
    axis: Vector3  # unit vector: of a cue, normal to a plane, or along an edge
    position: Vector3  # [m] of the centre
    velocity: Vector3  # [m/s]
    spin: Vector3  # [m/s] radius times angular velocity
    lost: float  # [J] by the end of a cue that swung back


class Model(NamedTuple):
    """Law and tolerance with which a collision is solved."""

    law: int
    tolerance: float
    planar: bool  # slip never turns: nothing happens along any second tangent
    distances: bool  # open contacts have a distance; else they close as soon as they approach
    bodies: int  # number of bodies whose places are known (moving_bodies.py), or 0
    moves: bool  # whether these move while they collide
    interval: float  # time after which pressed contacts take their normals anew
    swing: float  # longest time that a collision goes on after `ImpactProgress.first_end`


class Workspace(NamedTuple):
    """Matrices of a collision of N contacts, and scratch arrays."""

    delassus: Any  # (3 N, 3 N) W: contact velocities per contact impulse
    reduced: Any  # (3 N, 3 N) the same, with the friction of sticking contacts eliminated
    coupled: Any  # (N, N + 1) active contacts that accelerate a contact by `reduced`, then -1
    stick_gain: Any  # (3 N, 3 N) friction of sticking contacts per other force
    matrix: Any  # (3, 2 N, 2 N) scratch
    newton: Any  # (IMPLICIT_STAGES N, IMPLICIT_STAGES N) scratch
    residual: Any  # (IMPLICIT_STAGES N,) scratch
    vector: Any  # (3, 3 N) scratch; row 2: velocities before the collision
    polynomials: Any  # (3, MAX_COEFFICIENTS) scratch
    indices: Any  # (2 N,) scratch
    stages: Any  # (IMPLICIT_STAGES,) nodes of an implicit step
    # (IMPLICIT_STAGES, IMPLICIT_STAGES) from values at the nodes to integrals at the nodes
    integral: Any
    monomial: Any  # (IMPLICIT_STAGES, IMPLICIT_STAGES) from values at the nodes to coefficients
    history: Any  # (HISTORY, SECTION N) of kernel.py
    hashes: Any  # (HISTORY,)
    bodies: list[BodyState]  # 2 N + 2, of moving_bodies.py
    motion: Any  # (2 N + 2, 12, MAX_COEFFICIENTS) one matrix per body


def workspace(storage: Storage, count: int, tableau: tuple[Any, ...]) -> Workspace:
    """Allocate the workspace of N contacts; `tableau`: of collocation, in the storage."""
    zeros, size, nodes = storage.zeros, 3 * count, IMPLICIT_STAGES * count
    delassus, reduced, stick_gain = zeros(3, size, size)
    stages, integral, monomial = tableau
    return Workspace(
        delassus,
        reduced,
        storage.array(np.zeros((count, count + 1), np.int64)),
        stick_gain,
        zeros(3, 2 * count, 2 * count),
        zeros(nodes, nodes),
        residual=zeros(nodes),
        vector=zeros(3, size),
        polynomials=zeros(3, MAX_COEFFICIENTS),
        indices=storage.array(np.zeros(2 * count, np.int64)),
        stages=stages,
        integral=integral,
        monomial=monomial,
        history=zeros(HISTORY, SECTION * count),
        hashes=storage.array(np.zeros(HISTORY, np.int64)),
        bodies=storage.records(BodyState, 2 * count + 2),
        motion=zeros(2 * count + 2, 12, MAX_COEFFICIENTS),
    )


@inner
def clear_results(c: Any) -> None:
    """Set the results of a contact, in its state or in a `ContactResult`, to those of nothing."""
    c.impulse[0] = c.impulse[1] = c.impulse[2] = 0.0
    c.restitution_loss, c.friction_loss = 0.0, 0.0
    c.final_slip, c.slid, c.slid_to_peak = 0.0, 0.0, 0.0
    c.began, c.touched, c.lifted = 0.0, 0.0, 0.0
    c.discontinuity_margin = inf


@inner
def is_active(c: ContactState) -> bool:
    """Whether a contact exerts forces."""
    return c.normal_mode != INACTIVE


@inner
def is_pressed(c: ContactState) -> bool:
    """Whether the bodies of a contact press each other."""
    return c.normal_mode == COMPRESSION or c.normal_mode == RESTITUTION


@inner
def slips(c: ContactState) -> bool:
    """Whether a contact slips against friction, or is about to."""
    return SLIP <= c.friction_mode <= CREEP


@inner
def shears(c: ContactState) -> bool:
    """Whether the force of a tangential spring resists slip at a contact."""
    return c.friction_mode >= GRIP


@inner
def friction_is_explicit(c: ContactState) -> bool:
    """Whether friction follows from the state of a contact; not so if the contact sticks."""
    return c.friction_mode >= SLIP


@inner
def resists(c: ContactState) -> bool:
    """Whether friction acts at a contact."""
    return c.friction_mode > DEFERRED


@inner
def sticks(c: ContactState) -> bool:
    """Whether friction holds a contact."""
    return c.friction_mode == STICK or c.friction_mode == REDUNDANT_STICK


@inner
def is_stiff(m: Model, c: ContactState) -> bool:
    """Whether a contact needs implicit steps."""
    return c.friction_mode == CREEP or (c.friction_mode == SLIP_ONSET and not m.planar)


@inner
def force_is_negligible(c: ContactState) -> bool:
    """Whether a contact presses so little that its force is taken as zero."""
    smooth = c.exponent == 1.0 and c.shear == 0.0
    return not smooth and c.compression[0] < c.negligible_compression


@inner
def slip_speed(c: ContactState) -> float:
    """Slip at a contact now."""
    return sqrt(c.slip_1[0] * c.slip_1[0] + c.slip_2[0] * c.slip_2[0])


@inner
def friction_at(c: ContactState, slip: float) -> float:
    """Coefficient of friction of a contact at a slip."""
    if c.fading == 0.0:
        return c.friction
    return c.friction - c.fading * (1.0 - exp(-c.decay * slip))


@inner
def elastic_friction(c: ContactState, k: int) -> tuple[float, float]:
    """Coefficient k of the force of an ELASTIC contact, from those of shift and slip."""
    return (
        -c.spring * c.shift_1[k] - c.damping * c.slip_1[k],
        -c.spring * c.shift_2[k] - c.damping * c.slip_2[k],
    )


@inner
def stop_slip(c: ContactState) -> None:
    """Set a contact's slip to exactly zero."""
    c.slip_1[0] = 0.0
    c.slip_2[0] = 0.0


@inner
def rest_open(c: ContactState) -> None:
    """Remove what is only rounding from the motion of an open contact, and any compression."""
    c.compression[0] = min(c.compression[0], 0.0)
    if abs(c.velocity[0]) <= METHOD_OPTIONS.rounding:
        c.velocity[0] = 0.0
        if c.compression[0] >= -METHOD_OPTIONS.rounding:  # nothing has reached it yet
            c.compression[0] = 0.0


@inner
def largest_coefficient(c: ContactState, k: int) -> float:
    """Largest coefficient k of a contact's velocities."""
    return max(abs(c.velocity[k]), abs(c.slip_1[k]), abs(c.slip_2[k]))


@inner
def components(c: ContactState, velocity: Floats, row: int) -> None:
    """Write a contact's velocity, normal and slip, into three components from a row on."""
    velocity[row], velocity[row + 1] = c.velocity[0], c.slip_1[0]
    velocity[row + 2] = c.slip_2[0]
