"""An explicit step of a collision: Taylor series, order by order; and the advance to its end."""

from math import inf, sqrt

from billiard_shot.compiled import inner, innermost
from billiard_shot.impact import friction, moving_bodies, state
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.numerics.polynomial import (
    evaluate,
    integral,
    integrals,
    power_coefficient,
    product_coefficient,
    product_integral,
)
from billiard_shot.records import Floats


@inner
def explicit_step(
    m: state.Model,
    contacts: list[state.ContactState],
    ws: state.Workspace,
    scale: float,
    order: int,
    tolerance: float,
) -> tuple[float, float]:
    """
    Expand the state in polynomials.

    Returns
    -------
    scale, length : float
        The scale of the polynomials, shorter than the given one if coefficients overflow, or 0 if
        they always do; and the length of the step in units of the scale.

    """
    while scale > 1e-100:
        expand(m, contacts, ws, scale, order)
        length = step_length(m, contacts, order, tolerance)
        if length > 0.0:
            return scale, length
        scale /= METHOD_OPTIONS.max_rescale
    return 0.0, 0.0


@innermost
def expand(
    m: state.Model,
    contacts: list[state.ContactState],
    ws: state.Workspace,
    scale: float,
    order: int,
) -> None:
    """Fill coefficients of forces (below `order`), velocities and compressions (to `order`)."""
    for k in range(order):
        for j in range(len(contacts)):
            c = contacts[j]
            if c.normal_mode == state.INACTIVE:
                continue
            if c.friction_mode == state.GRIP:
                expand_grip(c, k)
                continue
            stiffness = (
                friction.drag_stiffness(c) if c.friction_mode == state.DRAG else c.stiffness
            )
            c.force[k] = (
                0.0 if state.force_is_negligible(c) else force_coefficient(c, stiffness, k)
            )
            if c.friction_mode == state.DRAG:
                expand_drag(m.planar, c, scale, k)
            elif c.friction_mode == state.ELASTIC:
                c.friction_1[k], c.friction_2[k] = state.elastic_friction(c, k)
            elif state.slips(c):
                if m.planar:
                    c.size[k] = c.slip_1[k] * c.slip_dir_1 + c.slip_2[k] * c.slip_dir_2
                    c.press_1[k] = c.force[k] * c.slip_dir_1
                    c.press_2[k] = c.force[k] * c.slip_dir_2
                else:
                    expand_direction(c, k)
                expand_friction(c, k)
        integrate_coefficients(contacts, ws, scale, k)
    fill_stick_forces(contacts, ws, order)


@innermost
def force_coefficient(c: state.ContactState, stiffness: float, k: int) -> float:
    """Coefficient k of F = stiffness y**exponent, from y to order k and F to order k - 1."""
    if c.exponent == 1.0:
        return stiffness * c.compression[k]
    factor = stiffness if k == 0 else 1.0
    return factor * power_coefficient(c.compression, c.force, c.exponent, k)


@innermost
def expand_direction(c: state.ContactState, k: int) -> None:
    """
    Coefficient k of F d, where slip = size d and F is known to order k.

    size' = d . slip' gives k size_k from the lower orders of d; then size d = slip gives d_k.
    """
    if k == 0:
        size = sqrt(c.slip_1[0] * c.slip_1[0] + c.slip_2[0] * c.slip_2[0])
        c.size[0] = max(size, 1e-300)  # slip that is zero has no direction, and no friction
    growth = 0.0
    rest_1, rest_2 = c.slip_1[k], c.slip_2[k]
    push_1, push_2 = 0.0, 0.0
    for i in range(1, k):
        d_1, d_2 = c.dir_1[k - i], c.dir_2[k - i]
        growth += i * (c.slip_1[i] * d_1 + c.slip_2[i] * d_2)
        rest_1 -= c.size[i] * d_1
        rest_2 -= c.size[i] * d_2
        push_1 += c.force[i] * d_1
        push_2 += c.force[i] * d_2
    if k > 0:
        d_1, d_2 = c.dir_1[0], c.dir_2[0]
        size = growth / k + c.slip_1[k] * d_1 + c.slip_2[k] * d_2
        c.size[k] = size
        rest_1 -= size * d_1
        rest_2 -= size * d_2
        push_1 += c.force[k] * d_1
        push_2 += c.force[k] * d_2
    c.dir_1[k] = rest_1 / c.size[0]
    c.dir_2[k] = rest_2 / c.size[0]
    c.press_1[k] = push_1 + c.force[0] * c.dir_1[k]
    c.press_2[k] = push_2 + c.force[0] * c.dir_2[k]


@innermost
def expand_friction(c: state.ContactState, k: int) -> None:
    """
    Coefficient k of the friction -mu F d, where F d and the size of the slip are known to order k.

    If slip lowers mu, E = mu - mu(infinity) has E' = -decay size' E.
    """
    if c.fading == 0.0:
        c.friction_1[k] = -c.friction * c.press_1[k]
        c.friction_2[k] = -c.friction * c.press_2[k]
        return
    least, growth = c.friction - c.fading, 0.0
    if k == 0:
        c.coefficient[0] = state.friction_at(c, c.size[0])
    else:
        for i in range(1, k):
            growth += i * c.size[i] * c.coefficient[k - i]
        growth += k * c.size[k] * (c.coefficient[0] - least)
        c.coefficient[k] = -c.decay * growth / k
    rub_1, rub_2 = 0.0, 0.0
    for i in range(k + 1):
        rub_1 += c.coefficient[i] * c.press_1[k - i]
        rub_2 += c.coefficient[i] * c.press_2[k - i]
    c.friction_1[k], c.friction_2[k] = -rub_1, -rub_2


@innermost
def expand_grip(c: state.ContactState, k: int) -> None:
    """Coefficient k of the forces of a contact that grips; `sliding` is q of friction.py."""
    if state.force_is_negligible(c):
        c.force[k] = c.friction_1[k] = c.friction_2[k] = 0.0
        return
    y, u_1, u_2, power = c.compression, c.shift_1, c.shift_2, c.coefficient
    c.sliding[k] = product_coefficient(y, y, k)
    c.sliding[k] += c.shear * product_coefficient(u_1, u_1, k)
    c.sliding[k] += c.shear * product_coefficient(u_2, u_2, k)
    power[k] = power_coefficient(c.sliding, power, 0.5 * (c.exponent - 1.0), k)
    pull = -c.shear * c.stiffness
    c.force[k] = c.stiffness * product_coefficient(y, power, k)
    c.friction_1[k] = pull * product_coefficient(u_1, power, k)
    c.friction_2[k] = pull * product_coefficient(u_2, power, k)


@innermost
def expand_drag(planar: bool, c: state.ContactState, scale: float, k: int) -> None:
    """Coefficient k of the friction of a contact that drags, and k + 1 of its shear."""
    turning, width = friction.turning_of(planar, c), friction.cone_width(c)
    d_1, d_2 = c.dir_1, c.dir_2
    if turning == friction.FOLLOWS:
        expand_direction(c, k)
    elif turning == friction.STRAIGHT:
        d_1[k], d_2[k] = (c.slip_dir_1, c.slip_dir_2) if k == 0 else (0.0, 0.0)
        c.size[k] = c.slip_1[k] * d_1[0] + c.slip_2[k] * d_2[0]
        c.press_1[k], c.press_2[k] = c.force[k] * d_1[0], c.force[k] * d_2[0]
    else:
        y = c.compression
        d_1[k] = d_2[k] = 0.0
        d_1[k] = (c.shift_1[k] / width - product_coefficient(y, d_1, k)) / y[0]
        d_2[k] = (c.shift_2[k] / width - product_coefficient(y, d_2, k)) / y[0]
        c.size[k] = product_coefficient(c.slip_1, d_1, k) + product_coefficient(c.slip_2, d_2, k)
        c.press_1[k] = product_coefficient(c.force, d_1, k)
        c.press_2[k] = product_coefficient(c.force, d_2, k)
    c.sliding[k] = c.size[k] + width * c.compression_rate * c.velocity[k]
    c.friction_1[k], c.friction_2[k] = -c.friction * c.press_1[k], -c.friction * c.press_2[k]
    factor = scale / (k + 1)
    c.shift_1[k + 1] = factor * (c.slip_1[k] - product_coefficient(c.sliding, d_1, k))
    c.shift_2[k + 1] = factor * (c.slip_2[k] - product_coefficient(c.sliding, d_2, k))


@innermost
def integrate_coefficients(
    contacts: list[state.ContactState], ws: state.Workspace, scale: float, k: int
) -> None:
    """Coefficients k + 1 of velocities and compressions: u' = W F, y' = -rate u_n."""
    factor = scale / (k + 1)
    for i in range(len(contacts)):
        c = contacts[i]
        row, row_1, row_2 = ws.reduced[3 * i], ws.reduced[3 * i + 1], ws.reduced[3 * i + 2]
        normal, first, second = 0.0, 0.0, 0.0
        for j in ws.coupled[i]:
            if j < 0:
                break
            d = contacts[j]
            n = 3 * j
            force = d.force[k]
            normal += row[n] * force
            first += row_1[n] * force
            second += row_2[n] * force
            if state.friction_is_explicit(d):
                f_1, f_2 = d.friction_1[k], d.friction_2[k]
                normal += row[n + 1] * f_1 + row[n + 2] * f_2
                first += row_1[n + 1] * f_1 + row_1[n + 2] * f_2
                second += row_2[n + 1] * f_1 + row_2[n + 2] * f_2
        c.velocity[k + 1] = factor * normal
        if c.friction > 0.0:
            c.slip_1[k + 1] = factor * first
            c.slip_2[k + 1] = factor * second
        if c.friction_mode == state.ELASTIC or c.friction_mode == state.GRIP:
            c.shift_1[k + 1], c.shift_2[k + 1] = factor * c.slip_1[k], factor * c.slip_2[k]
    for j in range(len(contacts)):
        c = contacts[j]
        c.compression[k + 1] = -c.compression_rate * factor * c.velocity[k]


@inner
def fill_stick_forces(contacts: list[state.ContactState], ws: state.Workspace, count: int) -> None:
    """Fill in the friction of sticking contacts, as far as `count` coefficients or stages."""
    for i in range(len(contacts)):
        c = contacts[i]
        if not (state.is_active(c) and state.sticks(c)):
            continue
        gain_1, gain_2 = ws.stick_gain[3 * i + 1], ws.stick_gain[3 * i + 2]
        for k in range(count):
            c.friction_1[k] = 0.0
            c.friction_2[k] = 0.0
        for j in range(len(contacts)):
            d = contacts[j]
            if d.normal_mode == state.INACTIVE:
                continue
            n = 3 * j
            for k in range(count):
                c.friction_1[k] += gain_1[n] * d.force[k]
                c.friction_2[k] += gain_2[n] * d.force[k]
            if state.friction_is_explicit(d):
                for k in range(count):
                    f_1, f_2 = d.friction_1[k], d.friction_2[k]
                    c.friction_1[k] += gain_1[n + 1] * f_1 + gain_1[n + 2] * f_2
                    c.friction_2[k] += gain_2[n + 1] * f_1 + gain_2[n + 2] * f_2


@innermost
def step_length(
    m: state.Model, contacts: list[state.ContactState], order: int, tolerance: float
) -> float:
    """
    Length of a step in units of its scale, from the last two coefficients; 0 if they overflow.

    The error of the slip direction limits the step too. If another contact holds the slip, the
    velocities do not show the error of the friction.

    The series of y**exponent converges only up to twice the compression. Beyond, even errors
    within the tolerance may close a contact that only touches, as that of a ball with the cloth
    in a strike. In a rack all contacts press, and so many short steps would gain nothing.
    """
    last = 0.0
    before = 0.0
    turning = 0.0
    for j in range(len(contacts)):
        c = contacts[j]
        last = max(last, state.largest_coefficient(c, order))
        before = max(before, state.largest_coefficient(c, order - 1))
        if (state.slips(c) or c.friction_mode == state.DRAG) and not m.planar:
            turning = max(turning, abs(c.dir_1[order - 1]), abs(c.dir_2[order - 1]))
    if not (last < 1e200 and before < 1e200):
        return 0.0
    x = METHOD_OPTIONS.max_rescale
    if last > 1e-300:
        x = min(x, (tolerance / last) ** (1.0 / order))
    if before > 1e-300:
        x = min(x, (tolerance / before) ** (1.0 / (order - 1)))
    if 1e-300 < turning < inf:
        x = min(x, (METHOD_OPTIONS.direction_error / turning) ** (1.0 / (order - 1)))
    for j in range(len(contacts)):
        c = contacts[j]
        if not c.is_tip or c.exponent == 1.0 or state.force_is_negligible(c):
            continue
        if c.compression[1] * x > c.compression[0] > 0.0:
            x = c.compression[0] / c.compression[1]
    return METHOD_OPTIONS.explicit_margin * x


@inner
def friction_work(c: state.ContactState, order: int, x: float) -> float:
    """Integral from 0 to x of a contact's friction times its slip."""
    work = product_integral(c.friction_1, c.slip_1, order, x)
    return work + product_integral(c.friction_2, c.slip_2, order, x)


@inner
def sliding_way(c: state.ContactState, order: int, x: float) -> float:
    """Integral from 0 to x of the sliding speed of a contact; of its slip by Simpson's rule."""
    if c.friction == 0.0:  # only the first slip is known
        return x * state.slip_speed(c)
    if c.friction_mode == state.DRAG:
        return integral(c.sliding, order, x)
    if not state.slips(c):
        return 0.0
    half_1, half_2 = evaluate(c.slip_1, order, 0.5 * x), evaluate(c.slip_2, order, 0.5 * x)
    end_1, end_2 = evaluate(c.slip_1, order, x), evaluate(c.slip_2, order, x)
    total = state.slip_speed(c) + 4.0 * sqrt(half_1 * half_1 + half_2 * half_2)
    return (total + sqrt(end_1 * end_1 + end_2 * end_2)) * x / 6.0


@inner
def write_impulses(
    c: state.ContactState, scale: float, order: int, x: float, impulses: Floats, shifts: Floats
) -> None:
    """Write the impulses (3,) of a contact from 0 to x, and their integrals over the time."""
    impulses[0], shifts[0] = integrals(c.force, order, x)
    impulses[1], shifts[1] = integrals(c.friction_1, order, x) if state.resists(c) else (0.0, 0.0)
    impulses[2], shifts[2] = integrals(c.friction_2, order, x) if state.resists(c) else (0.0, 0.0)
    for k in range(3):
        impulses[k] *= scale
        shifts[k] *= scale * scale


@inner
def advance(
    m: state.Model,
    contacts: list[state.ContactState],
    ws: state.Workspace,
    scale: float,
    order: int,
    x: float,
) -> None:
    """Move the state to x on the polynomials, and add the impulses and the friction losses."""
    impulses, shifts = ws.vector[0], ws.vector[1]
    if m.moves:
        moving_bodies.drift(ws, m.bodies, scale * x)
    for j in range(len(contacts)):
        c = contacts[j]
        if c.normal_mode != state.INACTIVE:
            write_impulses(c, scale, order, x, impulses, shifts)
            for k in range(3):
                c.impulse[k] += impulses[k]
            if m.moves:
                moving_bodies.push_bodies(ws, c, shifts, moving_bodies.PLACE_ROWS, 0)
                moving_bodies.push_bodies(ws, c, impulses, moving_bodies.VELOCITY_ROWS, 0)
            if c.is_tip and c.closings == 1:
                c.slid += scale * sliding_way(c, order, x)
            if state.shears(c):
                friction.count_losses(c, scale, order, x)
            elif state.friction_is_explicit(c):
                c.friction_loss -= scale * friction_work(c, order, x)
    for j in range(len(contacts)):
        c = contacts[j]
        if m.moves and c.normal_mode == state.INACTIVE:
            moving_bodies.measure(c, ws)
            continue
        turning = (
            friction.turning_of(m.planar, c)
            if c.friction_mode == state.DRAG
            else friction.STRAIGHT
        )
        c.velocity[0] = evaluate(c.velocity, order, x)
        if c.friction > 0.0:
            c.slip_1[0] = evaluate(c.slip_1, order, x)
            c.slip_2[0] = evaluate(c.slip_2, order, x)
        if c.friction_mode >= state.ELASTIC:
            c.shift_1[0] = evaluate(c.shift_1, order, x)
            c.shift_2[0] = evaluate(c.shift_2, order, x)
        if c.friction_mode == state.SLIP_ONSET:
            c.friction_mode = state.SLIP if m.planar else state.CREEP
        c.compression[0] = evaluate(c.compression, order, x)
        if c.normal_mode == state.INACTIVE:
            state.rest_open(c)
            continue
        c.compression[0] = max(c.compression[0], 0.0)
        if c.friction_mode == state.DRAG:
            friction.hold_to_cone(c, turning)
