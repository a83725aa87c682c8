"""Changes of a collision's state at events: the arrows of the state transition diagram."""

from math import inf, sqrt

from billiard_shot.compiled import inner
from billiard_shot.impact.events import (
    ACTIVATION,
    CONE_EXIT,
    ImpactEvent,
    NORMAL_REVERSAL,
    RESTITUTION_END,
    SLIP_STOP,
    SPRING_EXHAUSTED,
    TIP_CLEAR,
)
from billiard_shot.impact.friction import eliminate_sticking, start_slip
from billiard_shot.impact.laws import elastic_energy, opening, POISSON
from billiard_shot.impact.moving_bodies import (
    free_tips,
    height_of,
    part,
    push_bodies,
    take_normal,
    VELOCITY_ROWS,
)
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.impact.shear import begin_drag, shear_force, spring_energy
from billiard_shot.impact.state import (
    COMPRESSION,
    ContactState,
    DRAG,
    FREE,
    friction_at,
    FRICTIONLESS,
    GRIP,
    INACTIVE,
    is_active,
    Model,
    RESTITUTION,
    shears,
    SLIP_ONSET,
    slip_speed,
    slips,
    STICK,
    sticks,
    stop_slip,
    Workspace,
)
from billiard_shot.impact.turning import turn_now
from billiard_shot.numerics.polynomial import evaluate


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
            take_normal(m.planar, contacts, ws, j, lead)
        activate(c, known and not m.distances)
        if m.moves:
            if c.closings > 1:
                c.lifted = max(c.lifted, height_of(contacts, ws, c.body_b))
            free_tips(contacts, ws)
    else:
        if event.kind == SPRING_EXHAUSTED:
            apply_remaining_impulse(m, contacts, ws, j)
        margin = recompression_margin(m, contacts, ws, j)
        c.discontinuity_margin = min(c.discontinuity_margin, margin)
        deactivate(m, c)
        if m.moves:
            part(contacts, ws, j)
    return True


@inner
def activate(c: ContactState, known: bool) -> None:
    """Make a contact active; `known`: whether its normal velocity is zero at the event."""
    c.normal_mode = COMPRESSION
    c.friction_mode = FRICTIONLESS
    c.compression[0] = c.shift_1[0] = c.shift_2[0] = 0.0
    c.compression_rate = 1.0
    c.activation_impulse = c.impulse
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
            c.restitution_end = c.impulse + c.restitution * (c.impulse - c.activation_impulse)
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
    acceleration = normal_acceleration(contacts, ws, j)
    if acceleration >= 0.0 or c.peak_compression == 0.0:
        return inf
    return c.velocity[0] * c.velocity[0] / (-2.0 * acceleration * c.peak_compression)


@inner
def normal_acceleration(contacts: list[ContactState], ws: Workspace, j: int) -> float:
    """Acceleration of a contact's normal velocity under the forces of this moment."""
    total = 0.0
    row = ws.reduced[3 * j]
    for k in range(len(contacts)):
        c = contacts[k]
        if is_active(c):
            response = row[3 * k]
            if shears(c):
                push, f_1, f_2 = shear_force(c, c.compression[0], c.shift_1[0], c.shift_2[0])
                total += response * push + row[3 * k + 1] * f_1 + row[3 * k + 2] * f_2
                continue
            if slips(c):
                friction = friction_at(c, slip_speed(c))
                response -= friction * row[3 * k + 1] * c.slip_dir_1
                response -= friction * row[3 * k + 2] * c.slip_dir_2
            total += response * c.stiffness * c.compression[0] ** c.exponent
    return total


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
    remaining = c.restitution_end - c.impulse
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
            d.impulse += amount * push[3 * k]
            d.impulse_1 += amount * push[3 * k + 1]
            d.impulse_2 += amount * push[3 * k + 2]
            if m.moves:
                for i in range(3):
                    ws.residual[i] = amount * push[3 * k + i]
                push_bodies(ws, d, ws.residual, VELOCITY_ROWS, 0)
        remaining -= amount
        if remaining > 0.0:
            c.friction_mode = FRICTIONLESS  # it stopped; no spring sets a direction
