"""The events of a collision, located within a step, and the changes of state at them."""

from enum import IntEnum
from math import inf, sqrt
from typing import NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact import moving_bodies
from billiard_shot.impact.beginning import turn_now
from billiard_shot.impact.friction import (
    begin_drag,
    cone_width,
    eliminate_sticking,
    FOLLOWS,
    normal_acceleration,
    set_forces,
    spring_energy,
    start_slip,
    turning_of,
)
from billiard_shot.impact.options import elastic_energy, METHOD_OPTIONS, opening, POISSON
from billiard_shot.impact.state import (
    COMPRESSION,
    ContactState,
    DEFERRED,
    DRAG,
    force_is_negligible,
    FREE,
    friction_at,
    FRICTIONLESS,
    GONE,
    GRIP,
    INACTIVE,
    is_stiff,
    MAX_COEFFICIENTS,
    Model,
    RESTITUTION,
    SHAFT,
    shears,
    SLIP_ONSET,
    slip_speed,
    slips,
    STICK,
    sticks,
    stop_slip,
    Workspace,
)
from billiard_shot.numerics.polynomial import evaluate, first_root, NO_ROOT, NOT_ZERO
from billiard_shot.records import Floats


class ImpactEventKind(IntEnum):
    """Kind of the event at the end of a step."""

    NO_EVENT = 0  # the step ends for the sake of accuracy
    NORMAL_REVERSAL = 1  # compression ends, or begins again
    RESTITUTION_END = 2
    ACTIVATION = 3  # an inactive contact closes
    SLIP_STOP = 4
    CONE_EXIT = 5  # the force of a sticking contact reaches the friction cone
    SPRING_EXHAUSTED = 6  # law poisson: the spring is empty before its impulse is complete
    TIP_CLEAR = 7  # a tip that a ball held aside does not overlap the ball any more


(
    NO_EVENT, NORMAL_REVERSAL, RESTITUTION_END, ACTIVATION, SLIP_STOP, CONE_EXIT, SPRING_EXHAUSTED,
    TIP_CLEAR,
) = map(int, ImpactEventKind)  # fmt: skip


class Step(NamedTuple):
    """A step of the integration, whose polynomials are in the contacts."""

    scale: float  # time per unit of x; 0 if no step is possible
    order: int  # of the velocities
    end: float  # x up to which the polynomials hold
    noise: float  # error of the polynomials, relative to the largest velocity
    error: float  # estimated error of the velocities
    tolerance: float  # of the velocities


class ImpactEvent(NamedTuple):
    """The end of a step: an event at a contact, or NO_EVENT."""

    x: float
    kind: int  # ImpactEventKind
    contact: int  # -1: none


@inner
def first_event(
    m: Model, contacts: list[ContactState], ws: Workspace, step: Step, speed: float
) -> ImpactEvent:
    """
    Locate the first event in (0, step.end]. If nothing happens, return NO_EVENT at the end.

    `speed` is the velocity that `step.noise` is relative to. Of simultaneous events the last one
    found comes first; the others follow at once, in steps of zero length.
    """
    end, kind, contact = step.end, NO_EVENT, -1
    order, noise, work = step.order, step.noise, ws.polynomials
    for j in range(len(contacts)):
        c = contacts[j]
        if c.hold == GONE or c.normal_mode == SHAFT:
            continue
        if m.distances and c.normal_mode == INACTIVE:
            x = closing_root(c, step, speed, end, work)
            if x != NO_ROOT:
                end, kind, contact = x, ACTIVATION if c.hold == FREE else TIP_CLEAR, j
            continue
        sign = -1.0 if c.normal_mode == COMPRESSION else 1.0
        at_start = noise * speed if c.velocity[0] == 0.0 else NOT_ZERO
        x = first_root(c.velocity, order, sign, 0.0, at_start, end, work=work)
        opens = False
        if x == 0.0 and c.normal_mode == COMPRESSION and c.compression[0] == 0.0:
            # A reversal right after activation is rounding noise, unless the compression clearly
            # goes negative: contacts activated later may have pushed this one open.
            x = NO_ROOT
            opens = evaluate(c.compression, order, end) < -c.negligible_compression
        if x != NO_ROOT:
            end, contact = x, j
            kind = ACTIVATION if c.normal_mode == INACTIVE else NORMAL_REVERSAL
        if c.normal_mode == INACTIVE:
            continue
        if c.normal_mode == RESTITUTION:
            margin = METHOD_OPTIONS.end_margin * c.peak_compression
            goal = 0.0 if m.law == POISSON else c.restitution_end + margin
            x = first_root(c.compression, order, 1.0, goal, NOT_ZERO, end, work=work)
            if x != NO_ROOT:
                end, contact = x, j
                kind = SPRING_EXHAUSTED if m.law == POISSON else RESTITUTION_END
            if m.law == POISSON:
                x = impulse_root(c, ws, step, end)
                if x != NO_ROOT:
                    end, kind, contact = x, RESTITUTION_END, j
        elif force_is_negligible(c) or c.friction_mode == DEFERRED:
            x = first_root(
                c.compression, order, -1.0, -c.negligible_compression, NOT_ZERO, end, work=work
            )
            if x != NO_ROOT:
                end, kind, contact = x, NO_EVENT, j
        if slips(c) and not is_stiff(m, c):
            x, stops = slip_root(m, c, ws, order, noise * speed, end)
            if x != NO_ROOT:
                end, kind, contact = x, SLIP_STOP if stops else NO_EVENT, j
        elif c.friction_mode == STICK or (c.friction_mode == GRIP and not force_is_negligible(c)):
            x, leaves = cone_root(m, c, ws, step, speed, end)
            if x != NO_ROOT:
                end, kind, contact = x, CONE_EXIT if leaves else NO_EVENT, j
        elif c.friction_mode == DRAG and not force_is_negligible(c):
            at_start = noise * speed if c.sliding[0] <= noise * speed else NOT_ZERO
            x = first_root(c.sliding, order - 1, 1.0, 0.0, at_start, end, work=work)
            if x != NO_ROOT:
                end, kind, contact = x, SLIP_STOP, j
            if turning_of(m.planar, c) == FOLLOWS:
                x = lag_root(c, ws, order, end)
                if x != NO_ROOT:
                    end, kind, contact = x, NO_EVENT, j
        if opens and (kind != CONE_EXIT or contact != j):  # not by friction outside its cone
            end, kind, contact = 0.0, RESTITUTION_END, j
    return ImpactEvent(end, kind, contact)


@inner
def closing_root(c: ContactState, step: Step, speed: float, end: float, work: Floats) -> float:
    """First x at which an open contact closes; or, if it is HELD, at which it is clear."""
    at_start = step.noise * speed * step.scale if c.compression[0] == 0.0 else NOT_ZERO
    sign = -1.0 if c.hold == FREE else 1.0
    return first_root(c.compression, step.order, sign, 0.0, at_start, end, work=work)


@inner
def impulse_root(c: ContactState, ws: Workspace, step: Step, end: float) -> float:
    """First x at which the normal impulse ends the restitution of a contact (law poisson)."""
    p = ws.polynomials[2]
    p[0] = c.restitution_end - c.impulse[0]
    for k in range(step.order):
        p[k + 1] = -step.scale * c.force[k] / (k + 1)
    return first_root(p, step.order, 1.0, 0.0, NOT_ZERO, end, work=ws.polynomials)


@inner
def slip_root(
    m: Model, c: ContactState, ws: Workspace, order: int, noise: float, end: float
) -> tuple[float, bool]:
    """
    First x at which a contact's slip stops, or falls to the allowed minimum; whether it stops.

    If the slip direction turns, a step must not come too close to the end of the slip, because the
    series of the direction does not show that end. If the slip is straight to within the
    tolerance, its end is an ordinary root.
    """
    p = ws.polynomials[2]
    turning = 0.0
    power = end
    p[0] = c.slip_1[0] * c.slip_dir_1 + c.slip_2[0] * c.slip_dir_2
    for k in range(1, order + 1):
        p[k] = c.slip_1[k] * c.slip_dir_1 + c.slip_2[k] * c.slip_dir_2
        turning += abs(c.slip_2[k] * c.slip_dir_1 - c.slip_1[k] * c.slip_dir_2) * power
        power *= end
    if m.planar or turning <= METHOD_OPTIONS.planar_slip * m.tolerance:
        at_start = noise if c.friction_mode == SLIP_ONSET else NOT_ZERO
        return first_root(p, order, 1.0, 0.0, at_start, end, work=ws.polynomials), True
    kept = METHOD_OPTIONS.min_remaining_slip * slip_speed(c)
    return first_root(p, order, 1.0, kept, NOT_ZERO, end, work=ws.polynomials), False


@inner
def lag_root(c: ContactState, ws: Workspace, order: int, end: float) -> float:
    """First x at which the shear of a contact that drags no longer follows its slip at once."""
    p, width = ws.polynomials[2], cone_width(c)
    for k in range(order):
        p[k] = METHOD_OPTIONS.least_lag * c.size[k] - width * c.compression[k]
    return first_root(p, order - 1, 1.0, 0.0, NOT_ZERO, end, work=ws.polynomials)


@inner
def cone_root(
    m: Model, c: ContactState, ws: Workspace, step: Step, speed: float, end: float
) -> tuple[float, bool]:
    """
    First x at which the force of a contact that sticks or grips crosses its cone; if outwards.

    It may begin outside the cone, and come back, where a new normal has only just room for it.
    """
    order, least = step.order, 0.0  # the error of a shear is that of the slip over the step
    mu, normal, pull_1, pull_2 = c.friction, c.force, c.friction_1, c.friction_2
    if c.friction_mode == GRIP:
        mu, normal, pull_1, pull_2 = cone_width(c), c.compression, c.shift_1, c.shift_2
        least = 2.0 * step.noise * speed * step.scale * max(end, 1.0)
    largest, tangential, power = 0.0, 0.0, 1.0
    for k in range(order):
        largest += abs(normal[k]) * power
        tangential += (abs(pull_1[k]) + abs(pull_2[k])) * power
        power *= end
    smallest = 2.0 * abs(normal[0]) - largest
    if mu * smallest > tangential or tangential == 0.0:
        return NO_ROOT, False
    # All products count: those beyond the order are far larger than the errors of the forces.
    p, degree = ws.polynomials[2], min(2 * order - 2, MAX_COEFFICIENTS - 1)
    for k in range(degree + 1):
        p[k] = 0.0
        for i in range(max(k - order + 1, 0), k // 2 + 1):
            product = mu * mu * normal[i] * normal[k - i]
            product -= pull_1[i] * pull_1[k - i] + pull_2[i] * pull_2[k - i]
            p[k] += product if 2 * i == k else 2.0 * product
    noise = max(step.noise * mu * largest, least) * mu * largest
    if m.interval < inf and p[0] < -noise and p[1] > 0.0:
        return first_root(p, degree, -1.0, 0.0, NOT_ZERO, end, work=ws.polynomials), False
    at_start = noise if p[0] <= noise else NOT_ZERO
    return first_root(p, degree, 1.0, 0.0, at_start, end, work=ws.polynomials), True


@inner
def apply(
    m: Model,
    contacts: list[ContactState],
    ws: Workspace,
    event: ImpactEvent,
    known: bool,
    remaining: float,
) -> bool:
    """
    Apply the transition of an event; return whether forces jumped.

    Parameters
    ----------
    m, contacts, ws, event
        The model, the contacts, the workspace, and the event.
    known : bool
        Whether the normal velocity of the contact is zero at the event.
    remaining : float
        Time until pressed contacts take their normals anew.

    """
    j = event.contact
    c = contacts[j]
    if m.interval < inf and sticks(c) and not c.keeps_normal:
        about_to_slip = event.kind == CONE_EXIT and not c.is_turned
        if about_to_slip or event.kind == RESTITUTION_END:
            turn_now(m, contacts, ws, j)
        if about_to_slip:  # if it leaves the cone with that normal, too
            return True
    if event.kind == TIP_CLEAR:
        c.hold, c.compression[0] = FREE, 0.0
        return False
    if event.kind == NORMAL_REVERSAL:
        reverse_normal_motion(m, c, known)
        return False
    if event.kind == CONE_EXIT:
        if c.friction_mode == GRIP:
            begin_drag(c)
        else:
            start_slip(contacts, ws, j)
        return False
    if event.kind == SLIP_STOP:
        if c.friction_mode == DRAG:
            c.friction_mode = GRIP
            return False
        stop_slip(c)
        if c.friction_mode == SLIP_ONSET:  # the slip that was to begin is less than noise
            c.friction_mode = STICK
            eliminate_sticking(contacts, ws)
            return False
    elif event.kind == ACTIVATION:
        if m.moves:
            lead = 0.0 if c.keeps_normal or m.interval == inf else 0.5 * remaining
            moving_bodies.take_normal(m.planar, contacts, ws, j, lead)
        activate(c, known and not m.distances)
        if m.moves:
            if c.closings > 1:
                c.lifted = max(c.lifted, moving_bodies.height_of(contacts, ws, c.body_b))
            moving_bodies.free_tips(contacts, ws)
    else:
        if event.kind == SPRING_EXHAUSTED:
            apply_remaining_impulse(m, contacts, ws, j)
        margin = recompression_margin(m, contacts, ws, j)
        c.discontinuity_margin = min(c.discontinuity_margin, margin)
        deactivate(m, c)
        if m.moves:
            moving_bodies.part(contacts, ws, j)
    return True


@inner
def activate(c: ContactState, known: bool) -> None:
    """Make a contact active; `known`: whether its normal velocity is zero at the event."""
    c.normal_mode = COMPRESSION
    c.friction_mode = FRICTIONLESS
    c.compression[0] = c.shift_1[0] = c.shift_2[0] = 0.0
    c.compression_rate = 1.0
    c.activation_impulse = c.impulse[0]
    c.closings += 1
    if known:
        c.velocity[0] = 0.0


@inner
def deactivate(m: Model, c: ContactState) -> None:
    """End a contact: count the energy left in its spring as lost, and store its slip."""
    c.restitution_loss += loss_since_peak(c) if c.normal_mode == RESTITUTION else 0.0
    c.restitution_loss += spring_energy(c)
    c.final_slip = 0.0 if sticks(c) else slip_speed(c)
    c.normal_mode = INACTIVE
    c.friction_mode = FRICTIONLESS
    c.compression[0] = 0.0
    c.compression_rate = 1.0 if m.distances else 0.0


@inner
def reverse_normal_motion(m: Model, c: ContactState, known: bool) -> None:
    """End a contact's compression, or start a recompression; `known` as for `activate`."""
    # Only the remaining impulse of another contact, or a new normal, changes a velocity at once.
    jumps = m.law == POISSON or m.interval < inf
    if known or not jumps or abs(c.velocity[0]) <= METHOD_OPTIONS.rounding:
        c.velocity[0] = 0.0
    y = c.compression[0]
    if c.normal_mode == COMPRESSION:
        if c.closings == 1 and y >= c.peak_compression:
            c.slid_to_peak = c.slid
        start_restitution(c, m.law, y)
        if m.law == POISSON:
            pressed = c.impulse[0] - c.activation_impulse
            c.restitution_end = c.impulse[0] + c.restitution * pressed
    else:
        if m.law != POISSON and c.peak_compression > 0.0:
            margin = (y - c.restitution_end) / c.peak_compression
            c.discontinuity_margin = min(c.discontinuity_margin, margin)
        c.normal_mode = COMPRESSION
        c.compression_rate = 1.0
        c.restitution_loss += loss_since_peak(c)


@inner
def start_restitution(c: ContactState, law: int, peak: float) -> None:
    """Start the restitution of a contact from its peak compression, by a law."""
    restitution = c.restitution
    if c.softening > 0.0 or c.early_softening > 0.0:
        energy = elastic_energy(c.stiffness, peak, c.exponent)
        divisor = 1.0 + c.early_softening * sqrt(energy) + c.softening * energy
        restitution = max(restitution / divisor, METHOD_OPTIONS.min_softened)
    opens = opening(law, restitution, c.exponent)
    c.normal_mode, c.peak_compression = RESTITUTION, peak
    c.compression_rate = opens.rate
    c.lost_share = 0.0 if shears(c) else opens.lost  # see count_losses
    c.restitution_end = peak * opens.end


@inner
def loss_since_peak(c: ContactState) -> float:
    """Energy lost while a contact's spring opened from its peak."""
    released = elastic_energy(c.stiffness, c.peak_compression, c.exponent)
    released -= elastic_energy(c.stiffness, c.compression[0], c.exponent)
    return c.lost_share * released


@inner
def recompression_margin(m: Model, contacts: list[ContactState], ws: Workspace, j: int) -> float:
    """
    Further decompression before recompression would have begun, relative to the peak.

    Infinite if no recompression was coming. A small value means that the contact only just ended.
    """
    c = contacts[j]
    if m.law == POISSON or c.normal_mode != RESTITUTION or c.restitution == 0.0:
        return inf
    set_forces(contacts)
    acceleration, _size = normal_acceleration(contacts, ws, j)
    if acceleration >= 0.0 or c.peak_compression == 0.0:
        return inf
    return c.velocity[0] * c.velocity[0] / (-2.0 * acceleration * c.peak_compression)


@inner
def set_onset_direction(c: ContactState, order: int, x: float) -> None:
    """Let the slip of a sticking contact begin at x against the force that held it until then."""
    f_1 = evaluate(c.friction_1, order - 1, x)
    f_2 = evaluate(c.friction_2, order - 1, x)
    for k in range(order):
        if x == 0.0 and f_1 == 0.0 and f_2 == 0.0:
            f_1, f_2 = c.friction_1[k], c.friction_2[k]
    size = sqrt(f_1 * f_1 + f_2 * f_2)
    if size > 0.0:
        c.slip_dir_1, c.slip_dir_2 = -f_1 / size, -f_2 / size


@inner
def apply_remaining_impulse(m: Model, contacts: list[ContactState], ws: Workspace, j: int) -> None:
    """
    Law poisson: apply the rest of the impulse of a contact whose spring is empty.

    No other normal impulse changes. Friction keeps its mode: contacts stick, or slip until the
    slip stops. The energy that the spring does not have counts as a negative loss.
    """
    c, n = contacts[j], 3 * j
    push, change = ws.vector[0], ws.vector[1]
    size = 3 * len(contacts)
    remaining = c.restitution_end - c.impulse[0]
    while remaining > 0.0:
        for row in range(size):
            push[row] = ws.stick_gain[row][n]
        push[n] = 1.0
        if slips(c):
            friction = friction_at(c, slip_speed(c))
            push[n + 1], push[n + 2] = -friction * c.slip_dir_1, -friction * c.slip_dir_2
        for row in range(size):
            change[row] = ws.reduced[row][n]
            if slips(c):
                change[row] += ws.reduced[row][n + 1] * push[n + 1]
                change[row] += ws.reduced[row][n + 2] * push[n + 2]
        amount = remaining
        slip = c.slip_1[0] * c.slip_dir_1 + c.slip_2[0] * c.slip_dir_2
        rate = change[n + 1] * c.slip_dir_1 + change[n + 2] * c.slip_dir_2
        if slips(c) and slip + rate * amount < 0.0:
            amount = -slip / rate
        half = 0.5 * amount
        c.restitution_loss -= amount * push[n] * (c.velocity[0] + half * change[n])
        c.friction_loss -= amount * push[n + 1] * (c.slip_1[0] + half * change[n + 1])
        c.friction_loss -= amount * push[n + 2] * (c.slip_2[0] + half * change[n + 2])
        for k in range(len(contacts)):
            d = contacts[k]
            d.velocity[0] += amount * change[3 * k]
            d.slip_1[0] += amount * change[3 * k + 1]
            d.slip_2[0] += amount * change[3 * k + 2]
            for i in range(3):
                ws.residual[i] = amount * push[3 * k + i]
                d.impulse[i] += ws.residual[i]
            if m.moves:
                moving_bodies.push_bodies(ws, d, ws.residual, moving_bodies.VELOCITY_ROWS, 0)
        remaining -= amount
        if remaining > 0.0:
            c.friction_mode = FRICTIONLESS  # it stopped; no spring sets a direction
