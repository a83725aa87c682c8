"""
Leaps over swings that repeat: thousands of them at the price of a hundred.

Once swings were alike for a while, the walk is sent through single ones only, from the nodes of a
polynomial over ever more of them (multirevolution.py), to the accuracy of rounding. A leap that
passes a change of the sequence of events is taken back, and a shorter one tried.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import frugal
from billiard_shot.impact.collocation import NODES
from billiard_shot.impact.multirevolution import (
    extrapolate,
    finish,
    interpolate,
    move_nodes,
    residual,
    rest,
    set_nodes,
    weigh,
)
from billiard_shot.impact.state import Model, STAGES, State
from billiard_shot.impact.swings import (
    ALIKE,
    as_velocity,
    begin_swing,
    changed,
    copy,
    pack,
    SHORTEST,
    stays_zero,
    STEPS,
    Swings,
    UNCHANGED,
    unpack,
    WATCHING,
)

ROUNDING = 1e-15  # what a swing adds to the error of a leap, at most: many add up to the tolerance
LEAPT = 1e5  # swings that may be leapt over all the same
NUDGE = 1e-7  # relative change of a number to find its column of the Jacobian
SWEEPS = 14  # over the nodes, at most
SLOW = 3  # sweeps of a leap after which the next one has a Jacobian of its own
LESS = 0.3  # of a span after one whose equations were not solved
LEAST = 0.06  # of a span after one that went too far, at least
GROWTH = 8.0  # of a leap against the one before, at most
BLUR = 5e-14  # what rounding makes of a swing's highest coefficients, in units of the velocity
NO_LEAP, GOES_ON, TAKEN_BACK = 0, 1, 2


@frugal
def left(m: Model, w: Swings, stirred: float) -> float:
    """Swings that may still be leapt over."""
    return (max(LEAPT, m.tolerance / ROUNDING) - float(w.now[0].leapt)) / stirred


@frugal
def same_kind(s: State, w: Swings) -> bool:
    """Whether all contacts are in the condition in which the leap's swings begin."""
    for j in range(len(s.contact)):
        c, before = s.contact[j], w.contact[j]
        if c.phase != before.phase or c.grip != before.grip or c.young or c.pinned:
            return False
    return True


@frugal
def next_swing(
    m: Model, s: State, w: Swings, scale: float, tolerance: float, stirred: float
) -> int:
    """Go on after a swing has ended; unless the answer is NO_LEAP, the state was changed."""
    now = w.now[0]
    if now.node == WATCHING:
        alike = now.mark == now.last_mark and same_kind(s, w)
        now.alike = now.alike + 1 if alike else min(now.alike, 0)
        now.last_mark = now.mark
        copy(s.contact, w.contact)
        if now.alike < ALIKE or left(m, w, stirred) < SHORTEST:
            for i in range(w.reach.shape[0]):
                w.reach[i] = 0.0
            begin_swing(s, w, WATCHING)
            return NO_LEAP
        pack(s, w.span.start)
        now.scale, now.fresh = scale, 1
        w.span.jacobian[:, :] = 0.0
        send(m, s, w, UNCHANGED, w.span.start)
        return GOES_ON
    if now.node == UNCHANGED:
        now.leap_mark = now.mark
        if not same_kind(s, w):
            abandon(m, s, w)
            return TAKEN_BACK
        changed(m, s, w, w.first)
        find_column(m, s, w, 0)
        return GOES_ON
    if now.node < UNCHANGED:
        return end_column(m, s, w)
    if now.mark != now.leap_mark or not same_kind(s, w):
        abandon(m, s, w)
        return TAKEN_BACK
    changed(m, s, w, w.span.change[now.node])
    if now.node < STAGES - 1:
        send(m, s, w, now.node + 1, w.span.node[now.node + 1])
        return GOES_ON
    return end_sweep(m, s, w, tolerance, stirred)


@frugal
def send(m: Model, s: State, w: Swings, node: int, x: NDArray[np.float64]) -> None:
    """Begin a swing at x; where x is beyond the end of a contact, it is given up at once."""
    unpack(m, s, w, x)
    begin_swing(s, w, node)
    for j in range(len(s.contact)):
        if s.y[j, 0] < 0.0 < w.span.start[3 * len(s.contact) + j]:
            w.now[0].steps = STEPS


@frugal
def find_column(m: Model, s: State, w: Swings, column: int) -> None:
    """Begin a swing with one number changed a little; after the last of them, the leap."""
    now, p = w.now[0], w.span
    while column < p.jacobian.shape[0]:
        now.nudge = NUDGE * max(abs(p.start[column]), 10.0 * w.reach[column])
        if now.nudge > 0.0 and not stays_zero(w, column):
            copy(p.start, p.end)
            p.end[column] += now.nudge
            send(m, s, w, UNCHANGED - 1 - column, p.end)
            return
        column += 1
    if now.fresh:
        now.fresh = 0
        for i in range(w.first.shape[0]):
            for k in range(STAGES):
                p.change[k, i] = w.first[i]
    set_out(m, s, w)


@frugal
def end_column(m: Model, s: State, w: Swings) -> int:
    """Note the column of the Jacobian that the swing gave; go on with the next."""
    now, p = w.now[0], w.span
    column = UNCHANGED - 1 - now.node
    if now.mark == now.leap_mark and same_kind(s, w):
        changed(m, s, w, p.end)
        for i in range(p.jacobian.shape[0]):
            p.jacobian[i, column] = (p.end[i] - w.first[i]) / now.nudge
    find_column(m, s, w, column + 1)
    return GOES_ON


@frugal
def set_out(m: Model, s: State, w: Swings) -> None:
    """Begin a leap from what is known of F, which says where the nodes may be."""
    now, p = w.now[0], w.span
    now.sweep, now.span, now.tail = 0, np.floor(now.next_span), np.inf
    weigh(p, now.span)
    set_nodes(p)
    send(m, s, w, 0, p.node[0])


@frugal
def end_sweep(m: Model, s: State, w: Swings, tolerance: float, stirred: float) -> int:
    """All nodes were swept: leap, sweep again, or give up."""
    now, p = w.now[0], w.span
    now.sweep += 1
    off, tail, blurred = 0.0, 0.0, True  # the first two in parts of what is allowed
    for row in range(p.jacobian.shape[0]):
        size = as_velocity(m, s, row)
        blur = BLUR * now.span * max(abs(p.node[STAGES - 1, row]) * size, stirred)
        allowed = max(tolerance * min(stirred, 1.0), blur)
        unresolved = now.span * rest(p, row) * size
        off = max(off, residual(p, row) * size / allowed)
        tail = max(tail, unresolved / allowed)
        blurred = blurred and unresolved <= blur
    settles = tail > 1.0 and tail < 0.5 * now.tail
    now.tail = tail
    if (off > 1.0 or settles) and now.sweep < SWEEPS and move_nodes(p):
        send(m, s, w, 0, p.node[0])
        return GOES_ON
    grown = 4.0 if blurred else 0.8 * tail ** (-1.0 / STAGES)
    now.next_span = now.span * min(max(grown, 0.1), GROWTH)
    if not off <= 1.0:
        take_back(m, s, w, LESS * now.span)
        return TAKEN_BACK
    if not tail <= 1.0:
        if not now.next_span >= SHORTEST:
            take_back(m, s, w, now.next_span)
            return TAKEN_BACK
        interpolate(p, np.floor(now.next_span) / now.span)
        set_out(m, s, w)
        return GOES_ON
    finish(p)
    now.leapt += now.span * stirred
    now.next_span = min(max(now.next_span, SHORTEST), left(m, w, stirred))
    if now.next_span < SHORTEST:
        abandon(m, s, w)
        return TAKEN_BACK
    extrapolate(p, np.floor(now.next_span) / now.span)
    if now.sweep > SLOW:
        send(m, s, w, UNCHANGED, p.start)
    else:
        set_out(m, s, w)
    return GOES_ON


@frugal
def abandon(m: Model, s: State, w: Swings) -> None:
    """Give a leap up at the node it has come to, and try one that ends before."""
    now = w.now[0]
    reached = max(NODES[now.node - 1], LEAST) if now.node > 0 else LEAST
    take_back(m, s, w, now.span * reached)


@frugal
def take_back(m: Model, s: State, w: Swings, next_span: float) -> None:
    """Go back to a leap's start, and try one of `next_span` swings; if that is too few, wait."""
    now = w.now[0]
    if next_span >= SHORTEST:
        now.alike, now.next_span = ALIKE - 1, next_span
    else:
        now.alike, now.next_span = -3 * ALIKE, SHORTEST
    send(m, s, w, WATCHING, w.span.start)
