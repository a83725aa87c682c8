"""
Start of a collision: contacts and progress in the units of the collision.

The solver works in units of the largest approach speed, response and stiffness. Its results
therefore do not depend on the scale of these quantities.
"""

from math import inf, sqrt
from typing import Any, NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact.laws import elastic_energy
from billiard_shot.impact.moving_balls import (
    change_units,
    in_units,
    kinetic_energy,
    release_open_contacts,
)
from billiard_shot.impact.options import negligible_speed, OPTIONS
from billiard_shot.impact.state import (
    Balls,
    COMPRESSION,
    ContactState,
    FRICTIONLESS,
    INACTIVE,
    Model,
    Progress,
    Workspace,
)
from billiard_shot.impact.transitions import start_restitution
from billiard_shot.records import record, Vector
from billiard_shot.status import OK


class Units(NamedTuple):
    """The units in which a collision is solved; 0 if nothing approaches."""

    speed: float  # m/s
    impulse: float  # N s
    time: float  # s, if stiffnesses are in N/m^exponent


@record
class ContactProperties:
    """A contact of a collision, before it begins."""

    # The coefficient of friction at slip v is friction - fading (1 - exp(-decay v)).
    friction: float
    fading: float
    decay: float  # s/m
    restitution: float
    stiffness: float  # N/m^exponent; see `Contact`


class Collisions(NamedTuple):
    """
    n collisions of the same N contacts.

    Attributes
    ----------
    properties : n N ContactProperties
    law, exponent : int, float
        See `Model`.
    delassus : (n, 3 N, 3 N) floats
        W [1/kg]: contact velocities per impulse. Contact j has components 3 j (normal), 3 j + 1
        and 3 j + 2 (tangential). If all motion stays in one plane per contact, component 3 j + 1
        should lie in it and couplings to 3 j + 2 be exactly zero: that is cheaper.
    velocity : (n, 3 N) floats
        Contact velocities before the collision [m/s]; approaching if the normal one is below 0.
    distances : bool
        Whether open contacts have a distance, see `Model`.
    lengths : (n, N) floats
        Compressions of the springs before the collision [m]; if negative, minus the distances.
        Only law bistiffness defines how a spring that is already compressed continues. Unused
        without `distances`.
    until : float
        Time at which a collision ends, even if contacts are still active [s].
    balls : Balls
        Balls that move, or NO_BALLS if bodies stay in place. With balls there is only one
        collision: `Workspace.motion` holds their motion at its start and, afterwards, at its end.
    tolerance : (n,) floats
        Error of the velocities relative to the largest approach speed. A collision whose tolerance
        is not above 0 is skipped.

    """

    properties: list[ContactProperties]
    law: int
    exponent: float
    delassus: Any
    velocity: Any
    distances: bool
    lengths: Any
    until: float
    balls: Balls
    tolerance: Vector


@inner
def begin(
    given: Collisions, number: int, contacts: list[ContactState], ws: Workspace, p: Progress
) -> tuple[Model, Units]:
    """
    Set contacts and progress to the start of a collision, in the units of the collision.

    Returns the model and the units, which are zero if nothing approaches and nothing is pressed.
    """
    delassus, velocity = given.delassus[number], given.velocity[number]
    lengths = given.lengths[number]
    law, exponent, balls = given.law, given.exponent, given.balls
    distances = given.distances
    count = len(contacts)
    speed, mobility, firmness = 0.0, 0.0, 0.0
    for j in range(count):
        stiffness = given.properties[number * count + j].stiffness
        speed = max(speed, -velocity[3 * j])
        if distances and lengths[j] > 0.0:
            energy = elastic_energy(stiffness, lengths[j], exponent)
            speed = max(speed, sqrt(2.0 * energy * delassus[3 * j][3 * j]))
        mobility = max(mobility, delassus[3 * j][3 * j])
        firmness = max(firmness, stiffness)
    approaches = speed > 0.0 and mobility > 0.0
    tolerance = min(given.tolerance[number], OPTIONS.max_tolerance)
    start(p)
    if approaches:
        for row in range(3 * count):
            for column in range(3 * count):
                ws.delassus[row][column] = delassus[row][column] / mobility
        units = units_of(speed, mobility, firmness, exponent)
        for j in range(count):
            length = lengths[j] / (units.speed * units.time) if distances else 0.0
            properties = given.properties[number * count + j]
            start_contact(contacts[j], properties, velocity, units, firmness, distances, j)
            # Touching bodies that hardly approach would count as a motion that has died down.
            if length == 0.0 and abs(contacts[j].velocity[0]) < negligible_speed(tolerance):
                contacts[j].velocity[0] = 0.0
            start_length(contacts[j], law, exponent, length)
        planar = is_planar(contacts, ws)
        if balls.number > 0:
            balls = in_units(balls, mobility)
            change_units(contacts, ws.motion, balls.number, units.speed, units.speed * units.time)
            release_open_contacts(contacts, ws)
            p.energy = kinetic_energy(balls, ws.motion)
    else:
        units, planar = Units(0.0, 0.0, 0.0), False
    limit = given.until / units.time if approaches else inf
    return Model(law, exponent, tolerance, planar, distances, limit, balls), units


@inner
def units_of(speed: float, mobility: float, firmness: float, exponent: float) -> Units:
    """
    Find the units of a collision.

    F = k y^exponent, u' = W F and y' = u are free of units if W k time^(1 + exponent) =
    speed^(1 - exponent).
    """
    time = (speed ** (1.0 - exponent) / (mobility * firmness)) ** (1.0 / (1.0 + exponent))
    return Units(speed, speed / mobility, time)


@inner
def start_contact(
    c: ContactState,
    properties: ContactProperties,
    velocity: Vector,
    units: Units,
    firmness: float,
    distances: bool,
    j: int,
) -> None:
    """Set a contact to its state at the start of the collision."""
    speed = units.speed
    c.friction, c.fading = properties.friction, properties.fading
    c.decay = properties.decay * speed
    c.restitution, c.stiffness = properties.restitution, properties.stiffness / firmness
    c.velocity[0] = velocity[3 * j] / speed
    c.slip_1[0], c.slip_2[0] = velocity[3 * j + 1] / speed, velocity[3 * j + 2] / speed
    for values in (c.velocity, c.slip_1, c.slip_2):
        if abs(values[0]) < OPTIONS.rounding:
            values[0] = 0.0
        for k in range(1, len(values)):
            values[k] = 0.0
    c.compression_rate = 1.0 if distances else 0.0
    c.friction_mode = FRICTIONLESS
    c.peak_compression, c.restitution_end = 0.0, 0.0
    c.activation_impulse, c.negligible_compression = 0.0, 0.0
    c.slip_dir_1, c.slip_dir_2 = 0.0, 0.0
    c.impulse, c.impulse_1, c.impulse_2 = 0.0, 0.0, 0.0
    c.restitution_loss, c.friction_loss, c.final_slip = 0.0, 0.0, 0.0
    c.discontinuity_margin = inf


@inner
def start_length(c: ContactState, law: int, exponent: float, length: float) -> None:
    """Set the initial compression of a contact, or minus its initial distance."""
    c.compression[0] = length
    c.initial_energy = elastic_energy(c.stiffness, length, exponent)
    c.normal_mode = INACTIVE
    if length >= 0.0 and c.velocity[0] < 0.0:
        c.normal_mode, c.compression_rate = COMPRESSION, 1.0
    elif length > 0.0:
        start_restitution(c, law, exponent, length)
    c.closings = 0 if c.normal_mode == INACTIVE else 1


@inner
def start(p: Progress) -> None:
    """Set the progress to the start of a collision."""
    p.steps_since_event, p.events, p.event_hash, p.stiff = 0, 0, 0, 0
    p.section, p.section_start, p.sections = -1, 0, 0
    p.scale, p.speed = 1.0, 1.0
    p.modes_changed, p.phase_open = True, False
    p.status, p.phases, p.steps, p.time = OK, 0, 0, 0.0


@inner
def is_planar(contacts: list[ContactState], ws: Workspace) -> bool:
    """Whether no slip can ever turn, because nothing acts along any second tangent."""
    w = ws.delassus
    for i in range(len(contacts)):
        if contacts[i].friction > 0.0:
            if contacts[i].slip_2[0] != 0.0:
                return False
            for j in range(len(contacts)):
                if w[3 * i + 2][3 * j] != 0.0:
                    return False
                if contacts[j].friction > 0.0 and w[3 * i + 2][3 * j + 1] != 0.0:
                    return False
    return True
