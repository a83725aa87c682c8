"""The events of a collision, and how the first one within a step is located."""

from enum import IntEnum
from typing import NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact.laws import POISSON
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.impact.shear import cone_width, FOLLOWS, turning_of
from billiard_shot.impact.state import (
    COMPRESSION,
    ContactState,
    DEFERRED,
    DRAG,
    force_is_negligible,
    FREE,
    GONE,
    GRIP,
    INACTIVE,
    is_stiff,
    Model,
    RESTITUTION,
    SHAFT,
    SLIP_ONSET,
    slip_speed,
    slips,
    STICK,
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
            x = cone_root(c, ws, step, speed, end)
            if x != NO_ROOT:
                end, kind, contact = x, CONE_EXIT, j
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
    p[0] = c.restitution_end - c.impulse
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
def cone_root(c: ContactState, ws: Workspace, step: Step, speed: float, end: float) -> float:
    """First x at which the force of a contact that sticks or grips leaves the friction cone."""
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
        return NO_ROOT
    p = ws.polynomials[2]
    for k in range(order):
        p[k] = 0.0
        for i in range(k + 1):
            p[k] += mu * mu * normal[i] * normal[k - i]
            p[k] -= pull_1[i] * pull_1[k - i]
            p[k] -= pull_2[i] * pull_2[k - i]
    noise = max(step.noise * mu * largest, least) * mu * largest
    at_start = noise if p[0] <= noise else NOT_ZERO
    return first_root(p, order - 1, 1.0, 0.0, at_start, end, work=ws.polynomials)
