"""Advance of the state to the end of a step, with the impulses and losses of the step."""

from math import sqrt

from billiard_shot.compiled import inner
from billiard_shot.impact.moving_bodies import (
    drift,
    measure,
    PLACE_ROWS,
    push_bodies,
    VELOCITY_ROWS,
)
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.impact.shear import count_losses, hold_to_cone, STRAIGHT, turning_of
from billiard_shot.impact.state import (
    ContactState,
    CREEP,
    DRAG,
    ELASTIC,
    friction_is_explicit,
    INACTIVE,
    Model,
    resists,
    shears,
    SLIP,
    SLIP_ONSET,
    slip_speed,
    slips,
    Workspace,
)
from billiard_shot.numerics.polynomial import evaluate, integral, integrals, product_integral
from billiard_shot.records import Floats


@inner
def friction_work(c: ContactState, order: int, x: float) -> float:
    """Integral from 0 to x of a contact's friction times its slip."""
    work = product_integral(c.friction_1, c.slip_1, order, x)
    return work + product_integral(c.friction_2, c.slip_2, order, x)


@inner
def sliding_way(c: ContactState, order: int, x: float) -> float:
    """Integral from 0 to x of the sliding speed of a contact; of its slip by Simpson's rule."""
    if c.friction == 0.0:  # only the first slip is known
        return x * slip_speed(c)
    if c.friction_mode == DRAG:
        return integral(c.sliding, order, x)
    if not slips(c):
        return 0.0
    half_1, half_2 = evaluate(c.slip_1, order, 0.5 * x), evaluate(c.slip_2, order, 0.5 * x)
    end_1, end_2 = evaluate(c.slip_1, order, x), evaluate(c.slip_2, order, x)
    total = slip_speed(c) + 4.0 * sqrt(half_1 * half_1 + half_2 * half_2)
    return (total + sqrt(end_1 * end_1 + end_2 * end_2)) * x / 6.0


@inner
def write_impulses(
    c: ContactState, scale: float, order: int, x: float, impulses: Floats, shifts: Floats
) -> None:
    """Write the impulses (3,) of a contact from 0 to x, and their integrals over the time."""
    impulses[0], shifts[0] = integrals(c.force, order, x)
    impulses[1], shifts[1] = integrals(c.friction_1, order, x) if resists(c) else (0.0, 0.0)
    impulses[2], shifts[2] = integrals(c.friction_2, order, x) if resists(c) else (0.0, 0.0)
    for k in range(3):
        impulses[k] *= scale
        shifts[k] *= scale * scale


@inner
def advance(
    m: Model, contacts: list[ContactState], ws: Workspace, scale: float, order: int, x: float
) -> None:
    """Move the state to x on the polynomials, and add the impulses and the friction losses."""
    impulses, shifts = ws.vector[0], ws.vector[1]
    if m.moves:
        drift(ws, m.bodies, scale * x)
    for j in range(len(contacts)):
        c = contacts[j]
        if c.normal_mode != INACTIVE:
            write_impulses(c, scale, order, x, impulses, shifts)
            c.impulse += impulses[0]
            c.impulse_1 += impulses[1]
            c.impulse_2 += impulses[2]
            if m.moves:
                push_bodies(ws, c, shifts, PLACE_ROWS, 0)
                push_bodies(ws, c, impulses, VELOCITY_ROWS, 0)
            if c.is_tip and c.closings == 1:
                c.slid += scale * sliding_way(c, order, x)
            if shears(c):
                count_losses(c, scale, order, x)
            elif friction_is_explicit(c):
                c.friction_loss -= scale * friction_work(c, order, x)
    for j in range(len(contacts)):
        c = contacts[j]
        if m.moves and c.normal_mode == INACTIVE:
            measure(c, ws)
            continue
        turning = turning_of(m.planar, c) if c.friction_mode == DRAG else STRAIGHT
        c.velocity[0] = evaluate(c.velocity, order, x)
        if c.friction > 0.0:
            c.slip_1[0] = evaluate(c.slip_1, order, x)
            c.slip_2[0] = evaluate(c.slip_2, order, x)
        if c.friction_mode >= ELASTIC:
            c.shift_1[0] = evaluate(c.shift_1, order, x)
            c.shift_2[0] = evaluate(c.shift_2, order, x)
        if c.friction_mode == SLIP_ONSET:
            c.friction_mode = SLIP if m.planar else CREEP
        y = evaluate(c.compression, order, x)
        c.compression[0] = max(y, 0.0) if c.normal_mode != INACTIVE else min(y, 0.0)
        if c.friction_mode == DRAG:
            hold_to_cone(c, turning)
        if c.normal_mode == INACTIVE and abs(c.velocity[0]) <= METHOD_OPTIONS.rounding:
            c.velocity[0] = 0.0
            if (
                c.compression[0] >= -METHOD_OPTIONS.rounding
            ):  # a contact that nothing has reached yet
                c.compression[0] = 0.0
