"""Advance of the state to the end of a step, with the impulses and losses of the step."""

from math import sqrt

from billiard_shot.compiled import inner
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.impact.state import (
    ContactState,
    CREEP,
    ELASTIC,
    friction_is_explicit,
    INACTIVE,
    Model,
    resists,
    SLIP,
    SLIP_ONSET,
    slip_speed,
    slips,
)
from billiard_shot.numerics.polynomial import evaluate
from billiard_shot.records import Vector


@inner
def integral(c: Vector, order: int, x: float) -> float:
    """Integral from 0 to x of a polynomial with `order` coefficients."""
    total = 0.0
    for k in range(order - 1, -1, -1):
        total = total * x + c[k] / (k + 1)
    return total * x


@inner
def friction_work(c: ContactState, order: int, x: float) -> float:
    """Integral from 0 to x of a contact's friction times its slip."""
    total = 0.0
    power = x
    for n in range(order):
        product = 0.0
        for i in range(n + 1):
            product += c.friction_1[i] * c.slip_1[n - i] + c.friction_2[i] * c.slip_2[n - i]
        total += product * power / (n + 1)
        power *= x
    return total


@inner
def slip_way(c: ContactState, order: int, x: float) -> float:
    """Integral from 0 to x of the size of a contact's slip, by Simpson's rule."""
    half_1, half_2 = evaluate(c.slip_1, order, 0.5 * x), evaluate(c.slip_2, order, 0.5 * x)
    end_1, end_2 = evaluate(c.slip_1, order, x), evaluate(c.slip_2, order, x)
    total = slip_speed(c) + 4.0 * sqrt(half_1 * half_1 + half_2 * half_2)
    return (total + sqrt(end_1 * end_1 + end_2 * end_2)) * x / 6.0


@inner
def advance(m: Model, contacts: list[ContactState], scale: float, order: int, x: float) -> None:
    """Move the state to x on the polynomials, and add the impulses and the friction losses."""
    for j in range(len(contacts)):
        c = contacts[j]
        if c.normal_mode != INACTIVE:
            c.impulse += scale * integral(c.force, order, x)
            if resists(c):
                c.impulse_1 += scale * integral(c.friction_1, order, x)
                c.impulse_2 += scale * integral(c.friction_2, order, x)
            if c.closings == 1 and slips(c):
                c.slid += scale * slip_way(c, order, x)
            elif c.closings == 1 and c.friction == 0.0:  # only the first slip is known
                c.slid += scale * x * slip_speed(c)
            if friction_is_explicit(c):
                c.friction_loss -= scale * friction_work(c, order, x)
    for j in range(len(contacts)):
        c = contacts[j]
        if m.moves and c.normal_mode == INACTIVE:
            continue  # its state follows from its bodies: moving_bodies.py
        c.velocity[0] = evaluate(c.velocity, order, x)
        if c.friction > 0.0:
            c.slip_1[0] = evaluate(c.slip_1, order, x)
            c.slip_2[0] = evaluate(c.slip_2, order, x)
        if c.friction_mode == ELASTIC:
            c.shift_1[0] = evaluate(c.shift_1, order, x)
            c.shift_2[0] = evaluate(c.shift_2, order, x)
        if c.friction_mode == SLIP_ONSET:
            c.friction_mode = SLIP if m.planar else CREEP
        y = evaluate(c.compression, order, x)
        c.compression[0] = max(y, 0.0) if c.normal_mode != INACTIVE else min(y, 0.0)
        if c.normal_mode == INACTIVE and abs(c.velocity[0]) <= METHOD_OPTIONS.rounding:
            c.velocity[0] = 0.0
            if (
                c.compression[0] >= -METHOD_OPTIONS.rounding
            ):  # a contact that nothing has reached yet
                c.compression[0] = 0.0
