"""What can happen within a step: the first event on its polynomials."""

from billiard_shot.compiled import frugal, inlined
from billiard_shot.impact.laws import POISSON
from billiard_shot.impact.polynomial import evaluate, first_root, NO_ROOT, POSITIVE
from billiard_shot.impact.state import (
    COMPRESSING,
    INACTIVE,
    Model,
    RESTORING,
    SLIDING,
    slip_speed,
    State,
    STICKING,
)

NOTHING = 0  # the step ends for accuracy's sake
TURN = 1  # compression ends, or begins anew
END = 2  # an active contact has finished restitution
JOIN = 3  # an inactive contact closes
SLIP_STOP = 4  # sliding has come to a stop
CONE = 5  # a sticking contact reaches the friction cone
EMPTY = 6  # law `poisson` only: the spring is empty before its impulse is complete
SWING = 7  # a contact that stays pressed swings: its normal acceleration passes zero, downwards

SPENT = (
    1e-14  # part of the peak that counts as nothing, so that simultaneous ends stay simultaneous
)
SLIP_KEPT = 0.2  # a step may not use up more of the slip: its series would step over zero unseen


@frugal
def cone_root(m: Model, s: State, j: int, order: int, noise: float, end: float) -> float:
    """First x at which a sticking contact's force leaves the friction cone."""
    n = 3 * j
    largest = 0.0
    tangential = 0.0
    power = 1.0
    for k in range(order):
        largest += abs(s.force[n, k]) * power
        tangential += (abs(s.force[n + 1, k]) + abs(s.force[n + 2, k])) * power
        power *= end
    mu = s.contact[j].friction
    smallest = 2.0 * abs(s.force[n, 0]) - largest
    if mu * smallest > tangential or tangential == 0.0:
        return NO_ROOT
    scratch = s.work[3 * len(s.contact) :]
    c = scratch[2]
    for k in range(order):
        c[k] = 0.0
        for i in range(k + 1):
            c[k] += mu * mu * s.force[n, i] * s.force[n, k - i]
            c[k] -= s.force[n + 1, i] * s.force[n + 1, k - i]
            c[k] -= s.force[n + 2, i] * s.force[n + 2, k - i]
    noise *= (mu * largest) ** 2
    return first_root(c, order - 1, 1.0, 0.0, noise if c[0] <= noise else POSITIVE, end, scratch)


@frugal
def slip_root(
    m: Model, s: State, j: int, order: int, noise: float, end: float
) -> tuple[float, int]:
    """
    First x at which a contact's sliding has stopped, or has used up its share of slip.

    Where the slip turns, a step may not come too near to its end: the series of its direction
    would step over the stop unseen. Where it is straight to within the tolerance, the stop is a
    plain root.
    """
    scratch = s.work[3 * len(s.contact) :]
    c = scratch[2]
    dx, dy = s.contact[j].toward_x, s.contact[j].toward_y
    turning = 0.0
    power = end
    c[0] = s.u[3 * j + 1, 0] * dx + s.u[3 * j + 2, 0] * dy
    for k in range(1, order + 1):
        c[k] = s.u[3 * j + 1, k] * dx + s.u[3 * j + 2, k] * dy
        turning += abs(s.u[3 * j + 2, k] * dx - s.u[3 * j + 1, k] * dy) * power
        power *= end
    if m.straight or turning <= 1e-3 * m.tolerance:
        x = first_root(c, order, 1.0, 0.0, noise if s.contact[j].onset else POSITIVE, end, scratch)
        return x, SLIP_STOP
    x = first_root(c, order, 1.0, SLIP_KEPT * slip_speed(s, j), POSITIVE, end, scratch)
    return x, NOTHING


@frugal
def impulse_root(m: Model, s: State, j: int, scale: float, order: int, end: float) -> float:
    """First x at which a contact's normal impulse has reached its goal (law poisson)."""
    scratch = s.work[3 * len(s.contact) :]
    c = scratch[2]
    c[0] = s.contact[j].goal - s.impulse[3 * j]
    for k in range(order):
        c[k + 1] = -scale * s.force[3 * j, k] / (k + 1)
    return first_root(c, order, 1.0, 0.0, POSITIVE, end, scratch)


@frugal
def swing_root(s: State, j: int, order: int, end: float) -> float:
    """First x at which a contact's normal acceleration passes zero downwards, once a swing."""
    c = s.contact[j]
    if s.u[3 * j, 1] <= 0.0:
        c.armed = True
        return NO_ROOT
    if not c.armed:
        return NO_ROOT  # the step begins where it has just passed
    scratch = s.work[3 * len(s.contact) :]
    slope = scratch[2]
    for k in range(order):
        slope[k] = (k + 1) * s.u[3 * j, k + 1]
    return first_root(slope, order - 1, 1.0, 0.0, POSITIVE, end, scratch)


@inlined
def first_event(
    m: Model, s: State, scale: float, order: int, noise: float, stirred: float, end: float,
    listens: bool,
) -> tuple[float, int, int]:  # fmt: skip
    """
    Return (x, event, contact) of the first event in (0, end]; NOTHING at `end` if there is none.

    `noise`: how well the polynomials are known, those of velocities in units of `stirred`. Of
    simultaneous events the last one found comes first; the others follow at once, in steps of
    zero length.
    """
    event = NOTHING
    contact = -1
    scratch = s.work[3 * len(s.contact) :]
    for j in range(len(s.contact)):
        c = s.contact[j]
        opening = s.u[3 * j]
        sign = -1.0 if c.phase == COMPRESSING else 1.0
        known = noise * stirred if c.still else POSITIVE
        x = first_root(opening, order, sign, 0.0, known, end, scratch)
        opens = False
        if x == 0.0 and c.phase == COMPRESSING and s.y[j, 0] == 0.0:
            # It has only just joined. What turns it back is noise, unless it parts in earnest: the
            # forces of contacts that joined after it may have changed its mind.
            x = NO_ROOT
            opens = evaluate(s.y[j], order, end) < -c.faint
        if x != NO_ROOT:
            end, event, contact = x, JOIN if c.phase == INACTIVE else TURN, j
        if c.phase == INACTIVE:
            continue
        if c.phase == RESTORING:
            goal = 0.0 if m.law == POISSON else c.goal + SPENT * c.peak
            x = first_root(s.y[j], order, 1.0, goal, POSITIVE, end, scratch)
            if x != NO_ROOT:
                end, event, contact = x, EMPTY if m.law == POISSON else END, j
            if m.law == POISSON:
                x = impulse_root(m, s, j, scale, order, end)
                if x != NO_ROOT:
                    end, event, contact = x, END, j
        elif c.light or c.idle:
            x = first_root(s.y[j], order, -1.0, -c.faint, POSITIVE, end, scratch)
            if x != NO_ROOT:
                end, event, contact = x, NOTHING, j
        if listens:
            x = swing_root(s, j, order, end)
            if x != NO_ROOT:
                end, event, contact = x, SWING, j
        if c.grip == SLIDING and not c.young:
            x, kind = slip_root(m, s, j, order, noise * stirred, end)
            if x != NO_ROOT:
                end, event, contact = x, kind, j
        elif c.grip == STICKING and not c.pinned:
            x = cone_root(m, s, j, order, noise, end)
            if x != NO_ROOT:
                end, event, contact = x, CONE, j
        if opens and (event != CONE or contact != j):  # not by a friction that it cannot have
            end, event, contact = 0.0, END, j
    return end, event, contact
