"""The integration of a collision through its state transition diagram."""

from math import inf, log10, sqrt

from billiard_shot.compiled import inner
from billiard_shot.impact import events, friction, moving_bodies
from billiard_shot.impact.beginning import turn_normals
from billiard_shot.impact.collocation import implicit_step
from billiard_shot.impact.options import METHOD_OPTIONS, negligible_speed
from billiard_shot.impact.state import (
    ContactState,
    CREEP,
    DEFERRED,
    FREE,
    ImpactProgress,
    IMPLICIT_STAGES,
    INACTIVE,
    is_active,
    is_pressed,
    is_stiff,
    MAX_COEFFICIENTS,
    Model,
    PhaseLog,
    REDUNDANT_STICK,
    RESTITUTION,
    SHAFT,
    shears,
    SLIP,
    slip_speed,
    slips,
    STICK,
    stop_slip,
    Workspace,
)
from billiard_shot.impact.taylor import advance, explicit_step
from billiard_shot.status import BUDGET_EXCEEDED, INFINITE_SEQUENCE, NEGATIVE_ENERGY

SHORT_STEP_ORDERS = 3  # that a step does not need if it ends when normals turn
ENERGY_FLOOR = 10  # end of a phase that is not a kind of event: the motion has died down


@inner
def integrate(
    m: Model, contacts: list[ContactState], ws: Workspace, p: ImpactProgress, log: list[PhaseLog]
) -> bool:
    """
    Integrate a collision until it is over, or a section of it ends (kernel.py).

    Returns whether it is over; then `p.status` says how it ended.
    """
    while p.steps < steps_allowed(len(contacts)):
        if p.modes_changed or is_time_to_rescale(p):
            update_speed(m, contacts, ws, p)
        if p.modes_changed:
            p.modes_changed = False
            friction.assign_friction_modes(contacts, ws, zero_slip(m, p))
            if has_died_down(m, contacts, ws):
                return end(m, contacts, ws, p, log, INFINITE_SEQUENCE)
        step = propose_step(m, contacts, ws, p)
        if step.scale == 0.0:
            cancel_slip_onsets(m, contacts, m.tolerance * max(p.speed, 1.0))
            p.modes_changed, p.scale = True, 1.0
            continue
        if p.stiff == 0 and is_jammed(contacts, ws):
            return end(m, contacts, ws, p, log, p.status)
        event = events.first_event(m, contacts, ws, step, p.speed)
        take_step(m, contacts, ws, p, step, event)
        if m.interval < inf and not some_turn(contacts):
            p.next_turn = p.time + m.interval  # the next contact that closes begins an interval
        if event.kind != events.NO_EVENT:
            apply_event(m, contacts, ws, p, log, event)
            if tip_has_failed(contacts, p):
                return end(m, contacts, ws, p, log, p.status)
        if p.time >= (p.first_end + m.swing) * (1.0 - METHOD_OPTIONS.time_rounding):
            return end(m, contacts, ws, p, log, p.status)
        if is_over(contacts):
            if m.swing == 0.0 or not may_strike_again(contacts, ws):
                return True
            p.first_end = min(p.first_end, p.time)
        if is_time_to_turn(p):
            p.modes_changed = not turn_normals(m, contacts, ws) or p.modes_changed
            p.next_turn = p.time + m.interval
        p.scale = min(next_scale(p, step), METHOD_OPTIONS.max_step)
        if (
            p.events > METHOD_OPTIONS.tail_after
            and not m.distances
            and ends_section(contacts, p, event)
        ):
            return False
    p.status = BUDGET_EXCEEDED
    return True


@inner
def tip_has_failed(contacts: list[ContactState], p: ImpactProgress) -> bool:
    """Whether a tip slid too far, or touched its ball again too late or too high."""
    for j in range(len(contacts)):
        c = contacts[j]
        if c.is_tip and (c.slid_to_peak > p.max_slid_to_peak or c.slid > p.max_slid):
            return True
        if c.is_tip and c.closings > 1 and (c.began > p.max_again or c.lifted > p.max_lifted):
            return True
    return False


@inner
def steps_allowed(contacts: int) -> int:
    """Budget of steps of a collision."""
    return max(METHOD_OPTIONS.max_steps, METHOD_OPTIONS.max_steps_per_contact * contacts)


@inner
def is_time_to_rescale(p: ImpactProgress) -> bool:
    """Whether velocities may have grown unnoticed, because there was no event for a while."""
    return (
        p.steps_since_event % METHOD_OPTIONS.rescale_interval
        == METHOD_OPTIONS.rescale_interval - 1
    )


@inner
def is_time_to_turn(p: ImpactProgress) -> bool:
    """Whether pressed contacts take their normals anew."""
    return p.time >= p.next_turn * (1.0 - METHOD_OPTIONS.time_rounding)


@inner
def ends_section(
    contacts: list[ContactState], p: ImpactProgress, event: events.ImpactEvent
) -> bool:
    """Whether an event ends the compression of the contact that sections are counted by."""
    if event.kind != events.NORMAL_REVERSAL or contacts[event.contact].normal_mode != RESTITUTION:
        return False
    if p.section < 0 or p.events - p.section_start > METHOD_OPTIONS.max_section_events:
        p.section, p.sections = event.contact, 0
    if event.contact != p.section:
        return False
    p.section_start = p.events
    return True


@inner
def zero_slip(m: Model, p: ImpactProgress) -> float:
    """Slip below which a contact does not slip."""
    return METHOD_OPTIONS.zero_slip_share * m.tolerance * max(p.speed, 1.0)


@inner
def update_speed(m: Model, contacts: list[ContactState], ws: Workspace, p: ImpactProgress) -> None:
    """Find the largest velocity that a contact has, or that its spring could still give."""
    largest = 0.0
    for j in range(len(contacts)):
        c = contacts[j]
        if c.normal_mode == SHAFT:
            largest = max(largest, slip_speed(c))
        elif c.normal_mode == INACTIVE:
            largest = max(largest, -c.velocity[0] if c.hold == FREE else 0.0)
        else:
            largest = max(largest, active_speed(c, ws.delassus[3 * j][3 * j]))
    p.speed = largest if p.modes_changed else max(p.speed, largest)
    if p.modes_changed:
        for j in range(len(contacts)):
            c = contacts[j]
            least = METHOD_OPTIONS.negligible_force * m.tolerance * min(largest, 1.0)
            c.negligible_compression = (least / c.stiffness) ** (1.0 / c.exponent)
            if c.is_tip and c.exponent != 1.0:
                # also if it cannot change the velocity by that much; see taylor.step_length
                power = c.exponent + 1.0
                least *= power * abs(c.velocity[0]) / c.stiffness
                c.negligible_compression = max(c.negligible_compression, least ** (1.0 / power))


@inner
def active_speed(c: ContactState, response: float) -> float:
    """Velocity that an active contact has, or that its spring could still give."""
    energy = friction.spring_energy(c)
    return max(abs(c.velocity[0]), sqrt(2.0 * energy * response))


@inner
def has_died_down(m: Model, contacts: list[ContactState], ws: Workspace) -> bool:
    """
    Whether contacts are active or about to be, and all of these have negligible velocities.

    Bodies at a distance do not count: they may collide later.
    """
    speed = -1.0
    for j in range(len(contacts)):
        c = contacts[j]
        if is_pressed(c):
            speed = max(speed, active_speed(c, ws.delassus[3 * j][3 * j]))
        elif closes(c):
            speed = max(speed, -c.velocity[0])
    return 0.0 <= speed < negligible_speed(m.tolerance)


@inner
def propose_step(
    m: Model, contacts: list[ContactState], ws: Workspace, p: ImpactProgress
) -> events.Step:
    """Fill the polynomials of the longest step within the tolerance; scale 0 if none is found."""
    stiff, redundant = prepare_contacts(m, contacts)
    p.steps += 1 + METHOD_OPTIONS.implicit_cost * stiff * stiff
    p.steps_since_event += 1
    share = (
        METHOD_OPTIONS.step_share * m.tolerance * min(1.0, METHOD_OPTIONS.nominal_steps / p.steps)
    )
    tolerance = max(share * min(p.speed, 1.0), METHOD_OPTIONS.min_step_tolerance * p.speed)
    scale, length = p.scale, 1.0
    turns = m.interval < inf and some_turn(contacts)
    if stiff > 0:
        if p.stiff == 0:
            scale *= METHOD_OPTIONS.first_implicit_factor
        order = IMPLICIT_STAGES
        tolerance = max(
            METHOD_OPTIONS.implicit_factor * tolerance,
            METHOD_OPTIONS.min_implicit_tolerance * p.speed,
        )
        scale, error = implicit_step(m, contacts, ws, scale, tolerance)
        noise = max(METHOD_OPTIONS.rounding, error / p.speed)
    else:
        order = int(4.5 - log10(m.tolerance)) - (SHORT_STEP_ORDERS if turns else 0)
        order = min(max(order, 6), MAX_COEFFICIENTS - 4)
        scale, length = explicit_step(m, contacts, ws, scale, order, tolerance)
        error, noise = tolerance, max(METHOD_OPTIONS.rounding, tolerance / p.speed)
    p.stiff = stiff
    if scale > 0.0:
        if turns:
            length = min(length, max(p.next_turn - p.time, 0.0) / scale)
        if p.first_end < inf:
            length = min(length, max(p.first_end + m.swing - p.time, 0.0) / scale)
        if redundant:
            length = min(length, METHOD_OPTIONS.max_redundant_step / scale)
        if m.moves:
            moving_bodies.expand_distances(m.bodies, contacts, ws, scale, order, length)
    return events.Step(scale, order, length, noise, error, tolerance)


@inner
def some_turn(contacts: list[ContactState]) -> bool:
    """Whether a pressed contact takes its normal anew."""
    for j in range(len(contacts)):
        if is_active(contacts[j]) and not contacts[j].keeps_normal:
            return True
    return False


@inner
def prepare_contacts(m: Model, contacts: list[ContactState]) -> tuple[int, bool]:
    """Set the slip directions; count stiff contacts; return whether one sticks redundantly."""
    stiff, redundant = 0, False
    for j in range(len(contacts)):
        c = contacts[j]
        stiff += 1 if is_stiff(m, c) else 0
        redundant = redundant or c.friction_mode == REDUNDANT_STICK
        if (c.friction_mode == SLIP or c.friction_mode == CREEP) and not m.planar:
            size = slip_speed(c)
            if size > 0.0:
                c.slip_dir_1, c.slip_dir_2 = c.slip_1[0] / size, c.slip_2[0] / size
    return stiff, redundant


@inner
def take_step(
    m: Model,
    contacts: list[ContactState],
    ws: Workspace,
    p: ImpactProgress,
    step: events.Step,
    event: events.ImpactEvent,
) -> None:
    """Advance to an event, and update the friction modes."""
    if event.kind == events.CONE_EXIT:
        events.set_onset_direction(contacts[event.contact], step.order, event.x)
    if event.x > 0.0:
        p.phase_open = True
        for j in range(len(contacts)):
            if contacts[j].friction_mode == REDUNDANT_STICK:
                feasible = friction.sticking_is_feasible(contacts, ws, step.order, event.x)
                p.modes_changed = p.modes_changed or not feasible
                break
        advance(m, contacts, ws, step.scale, step.order, event.x)
        p.time += step.scale * event.x
        for j in range(len(contacts)):
            c = contacts[j]
            if c.friction_mode == CREEP and not creeps(ws, c, j, step.scale):
                c.friction_mode = SLIP
            if slips(c) and not m.planar and slip_speed(c) <= zero_slip(m, p):
                p.modes_changed = True
    if m.interval < inf and (event.kind == events.ACTIVATION or is_time_to_turn(p)):
        moving_bodies.find_accelerations(m.bodies, contacts, ws, step.order, event.x)
    for j in range(len(contacts)):
        c = contacts[j]
        presses = c.compression[0] >= (1.0 - 1e-9) * c.negligible_compression
        if c.friction_mode == DEFERRED and presses:
            c.friction_mode = STICK  # until modes are assigned
            p.modes_changed = True


@inner
def creeps(ws: Workspace, c: ContactState, j: int, length: float) -> bool:
    """Whether a contact slips too slowly for an explicit step of this length."""
    x, y = 3 * j + 1, 3 * j + 2
    response = max(ws.reduced[x][x], ws.reduced[y][y])
    turning = response * c.friction * c.stiffness * c.compression[0] ** c.exponent
    return slip_speed(c) < METHOD_OPTIONS.creeping_share * length * turning


@inner
def apply_event(
    m: Model,
    contacts: list[ContactState],
    ws: Workspace,
    p: ImpactProgress,
    log: list[PhaseLog],
    event: events.ImpactEvent,
) -> None:
    """Apply the transition of an event; first log the phase, if the event ends it."""
    kind, j = event.kind, event.contact
    p.steps_since_event = 0
    p.events += 1
    p.event_hash = (p.event_hash * 31 + 8 * j + kind) % 1_000_000_007
    if kind in (events.ACTIVATION, events.RESTITUTION_END, events.SPRING_EXHAUSTED):
        if p.phase_open:
            log_phase(m, contacts, p, log, kind, j)
        p.phase_open = False
    if kind == events.SPRING_EXHAUSTED:
        p.status = NEGATIVE_ENERGY
    known = event.x > 0.0 or contacts[j].velocity[0] == 0.0
    jumped = events.apply(m, contacts, ws, event, known, p.next_turn - p.time)
    if kind == events.ACTIVATION:
        contacts[j].began = p.time
    elif kind in (events.RESTITUTION_END, events.SPRING_EXHAUSTED):
        contacts[j].touched += p.time - contacts[j].began
    if kind == events.CONE_EXIT and p.stiff > 1:  # else slip onsets follow each other without end
        defer_friction(m, contacts)
        jumped = True
    p.modes_changed = p.modes_changed or jumped


@inner
def next_scale(p: ImpactProgress, step: events.Step) -> float:
    """Scale of the next step: as long as the tolerance allowed this one to be."""
    if p.stiff > 0:
        longer = (step.tolerance / max(step.error, 1e-300)) ** (1.0 / IMPLICIT_STAGES)
        growth = max(METHOD_OPTIONS.implicit_margin * longer, METHOD_OPTIONS.min_growth)
        return step.scale * min(growth, METHOD_OPTIONS.max_growth)
    return step.scale * min(
        max(step.end, 1.0 / METHOD_OPTIONS.max_rescale), METHOD_OPTIONS.max_rescale
    )


@inner
def cancel_slip_onsets(m: Model, contacts: list[ContactState], tolerance: float) -> None:
    """Cancel slip onsets that no implicit step resolves; contacts with finite slip keep it."""
    defer_friction(m, contacts)
    for j in range(len(contacts)):
        c = contacts[j]
        if is_stiff(m, c):
            if slip_speed(c) <= tolerance:
                stop_slip(c)
                c.friction_mode = STICK
            else:
                c.friction_mode = SLIP


@inner
def defer_friction(m: Model, contacts: list[ContactState]) -> None:
    """
    Defer friction at stiff contacts whose normal force is still negligible.

    If many contacts become active at once, the springs load one after the other, as ever higher
    powers of time. The first forces are significant long before the last ones can be resolved.
    """
    for j in range(len(contacts)):
        c = contacts[j]
        if is_stiff(m, c) and c.compression[0] < c.negligible_compression:
            c.friction_mode = DEFERRED


@inner
def is_jammed(contacts: list[ContactState], ws: Workspace) -> bool:
    """Whether the active contacts stay pressed together: no motion, and no acceleration."""
    for j in range(len(contacts)):
        c = contacts[j]
        if c.normal_mode == INACTIVE:
            if c.velocity[0] < 0.0:
                return False
            continue
        if c.normal_mode == SHAFT:
            if slip_speed(c) > METHOD_OPTIONS.jam_speed:
                return False
            continue
        if abs(c.velocity[0]) > METHOD_OPTIONS.jam_speed or slips(c):
            return False
        if shears(c) and slip_speed(c) > METHOD_OPTIONS.jam_speed:
            return False
        push, size = friction.normal_acceleration(contacts, ws, j)
        if abs(push) > METHOD_OPTIONS.rounding * size:
            return False
    return True


@inner
def is_over(contacts: list[ContactState]) -> bool:
    """Whether no contact is active and none is about to be."""
    for j in range(len(contacts)):
        c = contacts[j]
        if is_pressed(c) or closes(c):
            return False
    return True


@inner
def closes(c: ContactState) -> bool:
    """Whether the bodies of an open contact touch and approach each other."""
    approaches = c.velocity[0] < -METHOD_OPTIONS.rounding and c.hold == FREE
    return c.normal_mode == INACTIVE and approaches and c.compression[0] > -METHOD_OPTIONS.rounding


@inner
def end(
    m: Model,
    contacts: list[ContactState],
    ws: Workspace,
    p: ImpactProgress,
    log: list[PhaseLog],
    status: int,
) -> bool:
    """Log the last phase and end all contacts; return True."""
    log_phase(m, contacts, p, log, ENERGY_FLOOR, -1)
    for j in range(len(contacts)):
        if is_pressed(contacts[j]):
            contacts[j].touched += p.time - contacts[j].began
            events.deactivate(m, contacts[j])
            if m.moves:
                moving_bodies.part(contacts, ws, j)
    p.status = status
    return True


@inner
def log_phase(
    m: Model,
    contacts: list[ContactState],
    p: ImpactProgress,
    log: list[PhaseLog],
    ending: int,
    contact: int,
) -> None:
    """Count a phase that ends now, and log it if the log has room."""
    count = logged_contacts(contacts)
    first = p.phases * count
    p.phases += 1
    if first + count > len(log):
        return
    for j in range(count):
        c, row = contacts[j], log[first + j]
        row.ending, row.contact = ending, contact
        row.active = 1 if is_pressed(c) else 0
        row.impulse, row.impulse_1, row.impulse_2 = c.impulse[0], c.impulse[1], c.impulse[2]
        if m.bodies > 0:
            row.impulse, row.impulse_1 = (
                moving_bodies.impulse_along(c, 0),
                moving_bodies.impulse_along(c, 1),
            )
            row.impulse_2 = moving_bodies.impulse_along(c, 2)
        row.energy = friction.spring_energy(c)


@inner
def logged_contacts(contacts: list[ContactState]) -> int:
    """Return the number of contacts that are not shafts."""
    count = len(contacts)
    while count > 0 and contacts[count - 1].normal_mode == SHAFT:
        count -= 1
    return count


@inner
def may_strike_again(contacts: list[ContactState], ws: Workspace) -> bool:
    """Whether an end that swings may still bring its tip back to a ball."""
    for j in range(len(contacts)):
        shaft = contacts[j]
        if shaft.normal_mode == SHAFT:
            response = ws.delassus[3 * j + 1][3 * j + 1]
            stiffness = shaft.spring * response  # of the swing: its squared frequency
            rate = max(shaft.damping * response, sqrt(stiffness))
            x, y, speed = shaft.shift_1[0], shaft.shift_2[0], slip_speed(shaft)
            aside = sqrt(x * x + y * y)
            if speed + rate * aside > METHOD_OPTIONS.swing_left:
                fastest = sqrt(speed * speed + stiffness * aside * aside)
                for k in range(len(contacts)):
                    c = contacts[k]
                    opens = c.normal_mode == INACTIVE and c.hold == FREE
                    if opens and c.body_a == shaft.body_a and reaches(c, shaft, ws, fastest):
                        return True
    return False


@inner
def reaches(c: ContactState, shaft: ContactState, ws: Workspace, fastest: float) -> bool:
    """Whether tip and ball approach if the end swings back as fast as it can, or stops."""
    x, y, z = moving_bodies.separation_coefficient(c, ws, moving_bodies.PLACE_ROWS, 0)
    size = sqrt(x * x + y * y + z * z)
    swings = 0.0  # along the line of centres
    for k, along in enumerate((x, y, z)):
        across = shaft.slip_1[0] * shaft.tangent_1[k] + shaft.slip_2[0] * shaft.tangent_2[k]
        swings += along * across / size
    axis = ws.bodies[c.body_a].axis
    cosine = (x * axis[0] + y * axis[1] + z * axis[2]) / size
    sideways = sqrt(max(1.0 - cosine * cosine, 0.0))
    return c.velocity[0] - swings < sideways * fastest
