"""Start of a collision in its own units; the normals of moving bodies, taken anew."""

from math import inf, sqrt
from typing import Any, NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact import moving_bodies, state
from billiard_shot.impact.friction import eliminate_sticking, set_forces
from billiard_shot.impact.options import METHOD_OPTIONS, negligible_speed
from billiard_shot.impact.taylor import fill_stick_forces
from billiard_shot.records import Vector
from billiard_shot.status import OK

UNLIMITED = 1_000_000  # closings of a contact


class Units(NamedTuple):
    """The units in which a collision is solved; 0 if nothing approaches."""

    speed: float  # m/s
    impulse: float  # N s
    time: float  # s, if stiffnesses are in N/m^exponent


class TipLimits(NamedTuple):
    """
    Limits of the tip of a cue, beyond which its stroke has failed, and the collision ends there.

    Attributes
    ----------
    slid_to_peak, slid : float
        Way that the tip slides until it is pressed most, and until it parts first [m].
    again, lifted : float
        When the tip may not touch its ball again any more [s], and how high above the cloth [m].

    """

    slid_to_peak: float
    slid: float
    again: float
    lifted: float


NO_LIMITS = TipLimits(inf, inf, inf, inf)


class Collisions(NamedTuple):
    """
    n collisions of the same N contacts.

    Attributes
    ----------
    properties : n N ContactProperties
    law : int
        See `Model`.
    bodies : n B BodyState
        The bodies of the contacts, B of each collision; or none, if W and the velocities are
        given.
    delassus : (n, 3 N, 3 N) floats
        Unused with bodies. W [1/kg]: contact velocities per impulse. Contact j has components
        3 j (normal), 3 j + 1 and 3 j + 2 (tangential). If all motion stays in one plane per
        contact, component 3 j + 1 should lie in it and couplings to 3 j + 2 be exactly zero: that
        is cheaper.
    velocity : (n, 3 N) floats
        Unused with bodies. Contact velocities before the collision [m/s]; approaching if the
        normal one is below 0.
    distances : bool
        Whether open contacts have a distance, see `Model`.
    lengths : (n, N) floats
        Minus the distances before the collision [m]. Unused without `distances`, or with bodies.
    tolerance : (n,) floats
        Error of the velocities relative to the largest approach speed. A collision whose tolerance
        is not above 0 is skipped.
    moves : bool
        Whether the bodies move while they collide; needs `distances`.
    interval : float
        Time after which pressed contacts of bodies that move take their normals anew [s].
    swing : float
        See `Model`; [s].
    limits : TipLimits

    """

    properties: list[state.ContactProperties]
    law: int
    bodies: list[state.BodyState]
    delassus: Any
    velocity: Any
    distances: bool
    lengths: Any
    tolerance: Vector
    moves: bool = False
    interval: float = inf
    swing: float = 0.0
    limits: TipLimits = NO_LIMITS


@inner
def begin_collision(
    given: Collisions,
    number: int,
    contacts: list[state.ContactState],
    ws: state.Workspace,
    p: state.ImpactProgress,
) -> tuple[state.Model, Units]:
    """
    Set contacts and progress to the start of a collision, in the units of the collision.

    Returns the model and the units, which are zero if nothing approaches.
    """
    law, distances = given.law, given.distances
    count, bodies = len(contacts), len(given.bodies) // len(given.tolerance)
    velocity = ws.vector[2]
    for j in range(count):
        c, properties = contacts[j], given.properties[number * count + j]
        c.body_a, c.body_b = properties.body_a, properties.body_b
        c.keeps_normal, c.max_closings = properties.keeps_normal, properties.max_closings
        c.hold, c.is_tip = state.FREE if c.max_closings > 0 else state.GONE, False
        c.normal_mode = state.SHAFT if properties.is_shaft else state.INACTIVE
        c.is_turned = False
        for k in range(3):
            c.tangent_1[k] = properties.tangent[k]
    if bodies > 0:
        for b in range(bodies):
            moving_bodies.load_body(given.bodies[number * bodies + b], ws, b)
        for j in range(count):
            c = contacts[j]
            c.is_tip = c.normal_mode != state.SHAFT and ws.bodies[c.body_a].kind == state.TIP_BODY
        moving_bodies.place_contacts(contacts, ws, velocity)
    else:
        for row in range(3 * count):
            velocity[row] = given.velocity[number][row]
            for column in range(3 * count):
                ws.delassus[row][column] = given.delassus[number][row][column]
    speed, mobility = 0.0, 0.0
    for j in range(count):
        speed = max(speed, -velocity[3 * j] if contacts[j].hold == state.FREE else 0.0)
        mobility = max(mobility, ws.delassus[3 * j][3 * j])
    approaches = speed > 0.0 and mobility > 0.0
    tolerance = min(given.tolerance[number], METHOD_OPTIONS.max_tolerance)
    reset_progress(p)
    if not approaches:
        return state.Model(
            law, tolerance, False, distances, bodies, moves=False, interval=inf, swing=0.0
        ), Units(0.0, 0.0, 0.0)
    for row in range(3 * count):
        for column in range(3 * count):
            ws.delassus[row][column] /= mobility
    fastest = given.properties[number * count]
    time = time_of(fastest, speed, mobility)
    for j in range(1, count):
        other = given.properties[number * count + j]
        if not other.is_shaft and time_of(other, speed, mobility) < time:
            fastest, time = other, time_of(other, speed, mobility)
    units = Units(speed, speed / mobility, time)
    length = units.speed * units.time
    set_limits(p, given.limits, units.time, length)
    for j in range(count):
        c, properties = contacts[j], given.properties[number * count + j]
        start_contact(c, properties, velocity, units, fastest, distances, j=j)
        if c.normal_mode == state.SHAFT:
            start_shaft(c, properties, units)
            continue
        gap = 0.0
        if bodies > 0:
            gap = properties.gap
            c.closing_distance = c.reach = moving_bodies.distance_of_centres(c, ws) - gap
        elif distances:
            gap = -given.lengths[number][j]
        # Touching bodies that hardly approach would count as a motion that has died down.
        if gap == 0.0 and abs(c.velocity[0]) < negligible_speed(tolerance):
            c.velocity[0] = 0.0
        start_length(c, -gap / length if distances else 0.0)
    planar, interval = is_planar(contacts, ws), given.interval / units.time
    swing = given.swing / units.time
    m = state.Model(law, tolerance, planar, distances, bodies, given.moves, interval, swing=swing)
    if m.moves:
        moving_bodies.change_responses(ws, bodies, mobility)
        moving_bodies.change_units(contacts, ws, bodies, units.speed, length)
        moving_bodies.release_open_contacts(contacts, ws)
        p.energy, p.next_turn = moving_bodies.energy_of_bodies(ws, bodies), interval
        if interval < inf:
            turn_normals(m, contacts, ws)
    return m, units


@inner
def set_limits(p: state.ImpactProgress, limits: TipLimits, time: float, length: float) -> None:
    """Set the limits of a tip in units of time [s] and length [m]; by rounding never too small."""
    margin = 1.0 + METHOD_OPTIONS.time_rounding
    p.max_slid_to_peak = margin * limits.slid_to_peak / length
    p.max_slid = margin * limits.slid / length
    p.max_again = margin * limits.again / time
    p.max_lifted = margin * limits.lifted / length


@inner
def time_of(properties: state.ContactProperties, speed: float, mobility: float) -> float:
    """
    Time scale of a contact [s]: F = k y^exponent, u' = W F and y' = u are free of units.

    That is so if W k time^(1 + exponent) = speed^(1 - exponent).
    """
    exponent, firmness = properties.exponent, mobility * properties.stiffness
    return (speed ** (1.0 - exponent) / firmness) ** (1.0 / (1.0 + exponent))


@inner
def start_contact(
    c: state.ContactState,
    properties: state.ContactProperties,
    velocity: Vector,
    units: Units,
    fastest: state.ContactProperties,
    distances: bool,
    j: int,
) -> None:
    """Set a contact to its state at the start of the collision."""
    speed = units.speed
    c.friction, c.fading = properties.friction, properties.fading
    c.decay = properties.decay * speed
    c.restitution, c.exponent = properties.restitution, properties.exponent
    c.shear = properties.shear if c.friction > 0.0 else 0.0
    c.stiffness = properties.stiffness / fastest.stiffness
    if c.exponent != fastest.exponent:
        c.stiffness *= (speed * units.time) ** (c.exponent - fastest.exponent)
    c.early_softening = properties.early_softening * sqrt(units.impulse * speed)
    c.softening = properties.softening * units.impulse * speed
    c.velocity[0] = velocity[3 * j] / speed
    c.slip_1[0], c.slip_2[0] = velocity[3 * j + 1] / speed, velocity[3 * j + 2] / speed
    for values in (c.velocity, c.slip_1, c.slip_2):
        if abs(values[0]) < METHOD_OPTIONS.rounding:
            values[0] = 0.0
        for k in range(1, len(values)):
            values[k] = 0.0
    c.compression_rate = 1.0 if distances else 0.0
    c.friction_mode, c.shift_1[0], c.shift_2[0] = state.FRICTIONLESS, 0.0, 0.0
    c.peak_compression, c.restitution_end = 0.0, 0.0
    c.activation_impulse, c.negligible_compression = 0.0, 0.0
    c.slip_dir_1, c.slip_dir_2 = 0.0, 0.0
    state.clear_results(c)


@inner
def start_shaft(c: state.ContactState, properties: state.ContactProperties, units: Units) -> None:
    """Set the shaft of a cue to its state at the start of the collision: straight."""
    unit = units.impulse / units.speed  # kg
    c.spring = properties.spring * units.time * units.time / unit
    c.damping = properties.damping * units.time / unit
    c.friction, c.friction_mode = inf, state.ELASTIC  # it holds whatever the force is
    c.stiffness, c.exponent = 1.0, 1.0  # of a normal spring that is never compressed
    c.compression[0], c.compression_rate, c.closings = 0.0, 0.0, 0
    for values in (c.shift_1, c.shift_2, c.force):
        for k in range(len(values)):
            values[k] = 0.0


@inner
def start_length(c: state.ContactState, length: float) -> None:
    """Set minus the initial distance of a contact; close it if its bodies touch and approach."""
    c.compression[0] = length
    c.normal_mode = state.INACTIVE
    if length >= 0.0 and c.velocity[0] < 0.0 and c.hold == state.FREE:
        c.normal_mode, c.compression_rate = state.COMPRESSION, 1.0
    c.closings = 0 if c.normal_mode == state.INACTIVE else 1


@inner
def reset_progress(p: state.ImpactProgress) -> None:
    """Set the progress to the start of a collision."""
    p.steps_since_event, p.events, p.event_hash, p.stiff = 0, 0, 0, 0
    p.section, p.section_start, p.sections = -1, 0, 0
    p.scale, p.speed = 1.0, 1.0
    p.modes_changed, p.phase_open = True, False
    p.status, p.phases, p.steps, p.time, p.next_turn = OK, 0, 0, 0.0, inf
    p.first_end = inf


@inner
def is_planar(contacts: list[state.ContactState], ws: state.Workspace) -> bool:
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


@inner
def turn_normals(m: state.Model, contacts: list[state.ContactState], ws: state.Workspace) -> bool:
    """
    Take the normals of all pressed contacts anew that do not keep them.

    Returns whether friction modes stay as they are; then sticking friction is eliminated already.
    """
    for j in range(len(contacts)):
        if state.is_active(contacts[j]) and not contacts[j].keeps_normal:
            moving_bodies.take_normal(m.planar, contacts, ws, j, 0.5 * m.interval)
    some_stick = find_stopping_impulses(contacts, ws)
    if some_stick and not have_room(m, contacts, ws):
        return False
    if some_stick:
        stop_slips(m, contacts, ws)
    return True


@inner
def turn_now(
    m: state.Model, contacts: list[state.ContactState], ws: state.Workspace, j: int
) -> None:
    """Take the normal of this moment at a contact that sticks."""
    moving_bodies.take_normal(m.planar, contacts, ws, j, 0.0)
    contacts[j].is_turned = True
    find_stopping_impulses(contacts, ws)
    stop_slips(m, contacts, ws)


@inner
def find_stopping_impulses(contacts: list[state.ContactState], ws: state.Workspace) -> bool:
    """
    Write the impulses (3 N,) that stop all slip of sticking contacts into a scratch vector.

    Returns whether any contact sticks.
    """
    eliminate_sticking(contacts, ws)  # leaves the inverse of the sticking part of W
    stuck, inverse, impulses = ws.indices, ws.matrix[1], ws.vector[0]
    count = 0
    for j in range(len(contacts)):
        if state.is_active(contacts[j]) and state.sticks(contacts[j]):
            count += 2
    for a in range(count):
        impulses[stuck[a]] = 0.0
        for b in range(count):
            c = contacts[stuck[b] // 3]
            slip = c.slip_1[0] if stuck[b] % 3 == 1 else c.slip_2[0]
            impulses[stuck[a]] -= inverse[a][b] * slip
    return count > 0


@inner
def have_room(m: state.Model, contacts: list[state.ContactState], ws: state.Workspace) -> bool:
    """Whether the friction of each sticking contact can have its impulse in one interval."""
    impulses = ws.vector[0]
    set_forces(contacts)
    fill_stick_forces(contacts, ws, 1)
    for j in range(len(contacts)):
        c = contacts[j]
        if state.is_active(c) and state.sticks(c):
            x = c.friction_1[0] + impulses[3 * j + 1] / m.interval
            y = c.friction_2[0] + impulses[3 * j + 2] / m.interval
            rim = c.friction * c.force[0]
            if x * x + y * y > rim * rim:
                return False
    return True


@inner
def stop_slips(m: state.Model, contacts: list[state.ContactState], ws: state.Workspace) -> None:
    """Apply the impulses that stop the slip of sticking contacts; count their work as lost."""
    impulses, push = ws.vector[0], ws.residual
    for j in range(len(contacts)):
        c = contacts[j]
        if state.is_active(c) and state.sticks(c):
            push[0], push[1], push[2] = 0.0, impulses[3 * j + 1], impulses[3 * j + 2]
            moving_bodies.push_bodies(ws, c, push, moving_bodies.VELOCITY_ROWS, 0)
            c.impulse[1] += push[1]
            c.impulse[2] += push[2]
            c.friction_loss -= 0.5 * (push[1] * c.slip_1[0] + push[2] * c.slip_2[0])
    for j in range(len(contacts)):
        c = contacts[j]
        if state.is_active(c):
            c.velocity[0], c.slip_1[0], c.slip_2[0] = moving_bodies.velocity_of(c, ws)
            if m.planar:
                c.slip_2[0] = 0.0
        else:
            moving_bodies.measure(c, ws)
