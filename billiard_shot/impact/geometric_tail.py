"""
Infinite sequences of geometrically decaying cycles: the remaining cycles are summed as a series.

With linear springs the equations of a collision are homogeneous. If a state is scaled by a factor,
except for slip that continues, the same events follow after the same times. All impulses scale
with the factor, all energies with its square. Bodies that are pressed together lose a share of
their motion in every cycle of impacts. Their cycles therefore come to differ only by one ratio.
(With forces ~ y^p compressions shrink with another power, and the times grow. The series of the
impulses is the same.)

A section is the time from one end of a chosen contact's compression to the next. A cycle is one
section, or several.
"""

from math import sqrt

from billiard_shot.compiled import inner
from billiard_shot.impact.laws import elastic_energy, POISSON
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.impact.state import (
    ContactState,
    HISTORY,
    ImpactProgress,
    is_active,
    Model,
    SECTION,
    Workspace,
)
from billiard_shot.numerics import rounding
from billiard_shot.records import Floats

MAX_SECTIONS = (HISTORY - 1) // 2  # of a cycle

# A contact's part of the history.
NORMAL_VELOCITY, SLIP_1, SLIP_2, SPRING_COMPRESSION, IMPULSE, IMPULSE_1, IMPULSE_2 = range(7)
RESTITUTION_LOSS, FRICTION_LOSS, FINAL_SLIP = range(7, SECTION)


@inner
def ends_in_geometric_tail(
    m: Model, contacts: list[ContactState], ws: Workspace, p: ImpactProgress
) -> bool:
    """At the end of a section, add the rest if it is a geometric series; return whether it is."""
    record_section(contacts, ws, p)
    return m.law != POISSON and add_tail(m, contacts, ws, p)


@inner
def record_section(contacts: list[ContactState], ws: Workspace, p: ImpactProgress) -> None:
    """Write the state into the history."""
    row = p.sections % HISTORY
    ws.hashes[row] = p.event_hash
    p.event_hash = 0
    p.sections += 1
    x = ws.history[row]
    for j in range(len(contacts)):
        c, n = contacts[j], SECTION * j
        x[n + NORMAL_VELOCITY], x[n + SLIP_1], x[n + SLIP_2] = (
            c.velocity[0],
            c.slip_1[0],
            c.slip_2[0],
        )
        x[n + SPRING_COMPRESSION] = c.compression[0]
        x[n + IMPULSE], x[n + IMPULSE_1] = c.impulse, c.impulse_1
        x[n + IMPULSE_2] = c.impulse_2
        x[n + RESTITUTION_LOSS], x[n + FRICTION_LOSS] = c.restitution_loss, c.friction_loss
        x[n + FINAL_SLIP] = c.final_slip


@inner
def add_tail(m: Model, contacts: list[ContactState], ws: Workspace, p: ImpactProgress) -> bool:
    """Add the rest of a sequence to the state if it is a geometric series; return whether."""
    row = p.sections - 1
    for sections in range(1, MAX_SECTIONS + 1):
        if p.sections <= 2 * sections or not same_events(ws, row, sections):
            continue
        last = ws.history[row % HISTORY]
        before = ws.history[(row - sections) % HISTORY]
        first = ws.history[(row - 2 * sections) % HISTORY]
        size = amplitude(contacts, ws, before, first)
        ratio = amplitude(contacts, ws, last, before) / size if size > 0.0 else 1.0
        if ratio < METHOD_OPTIONS.max_tail_ratio and is_geometric(
            m, contacts, ws, last, before, first, ratio=ratio
        ):
            add_cycles(contacts, last, before, first, ratio)
            return True
    return False


@inner
def same_events(ws: Workspace, row: int, sections: int) -> bool:
    """Whether the last two cycles, of this many sections each, had the same events."""
    for k in range(row - sections + 1, row + 1):
        if ws.hashes[k % HISTORY] != ws.hashes[(k - sections) % HISTORY]:
            return False
    return True


@inner
def amplitude(contacts: list[ContactState], ws: Workspace, now: Floats, before: Floats) -> float:
    """Amplitude of the motion after a cycle, as a velocity, at the contacts that it pressed."""
    square = 0.0
    for j in range(len(contacts)):
        n = SECTION * j
        if now[n + IMPULSE] > before[n + IMPULSE]:
            c = contacts[j]
            energy = elastic_energy(c.stiffness, now[n + SPRING_COMPRESSION], c.exponent)
            square += now[n + NORMAL_VELOCITY] * now[n + NORMAL_VELOCITY]
            square += 2.0 * energy * ws.delassus[3 * j][3 * j]
    return sqrt(square)


@inner
def limit(now: float, before: float, ratio: float) -> float:
    """Limit of a number whose changes shrink by a ratio."""
    return now + (now - before) * ratio / (1.0 - ratio)


@inner
def is_geometric(
    m: Model, contacts: list[ContactState], ws: Workspace, now: Floats, before: Floats,
    first: Floats, ratio: float,
) -> bool:  # fmt: skip
    """Whether the last two cycles differ by the ratio only, and so do the states after them."""
    allowed = METHOD_OPTIONS.tail_share * m.tolerance * (1.0 - ratio) * (1.0 - ratio)
    for j in range(len(contacts)):
        c, n = contacts[j], SECTION * j
        response = ws.delassus[3 * j][3 * j]
        if now[n + IMPULSE] > before[n + IMPULSE]:
            shrinking = ratio ** (2.0 / (c.exponent + 1.0))  # energies go as ratio^2
            off = abs(now[n + SPRING_COMPRESSION] - shrinking * before[n + SPRING_COMPRESSION])
            if not off * sqrt(c.stiffness * response) <= allowed:
                return False
            if not abs(now[n + NORMAL_VELOCITY] - ratio * before[n + NORMAL_VELOCITY]) <= allowed:
                return False
        elif limit(now[n + NORMAL_VELOCITY], before[n + NORMAL_VELOCITY], ratio) < 0.0:
            return False  # it will close
        for k in range(3):
            response = ws.delassus[3 * j + k][3 * j + k]
            for row in (n + NORMAL_VELOCITY + k, n + IMPULSE + k):
                unit = 1.0 if row < n + IMPULSE else response
                off = abs((now[row] - before[row]) - ratio * (before[row] - first[row]))
                if not off * unit <= allowed + rounding.SUM * abs(now[row]) * unit:
                    return False
        slip_1, slip_2 = now[n + SLIP_1], now[n + SLIP_2]
        limit_1 = limit(slip_1, before[n + SLIP_1], ratio)
        limit_2 = limit(slip_2, before[n + SLIP_2], ratio)
        slip = sqrt(slip_1 * slip_1 + slip_2 * slip_2)
        if slip_1 * limit_1 + slip_2 * limit_2 < -METHOD_OPTIONS.tail_share * m.tolerance * slip:
            return False  # it will stop on the way
    return True


@inner
def add_cycles(
    contacts: list[ContactState], now: Floats, before: Floats, first: Floats, ratio: float
) -> None:
    """Set the state to the limit of a geometric sequence."""
    for j in range(len(contacts)):
        c, n = contacts[j], SECTION * j
        c.velocity[0] = limit(now[n + NORMAL_VELOCITY], before[n + NORMAL_VELOCITY], ratio)
        c.slip_1[0] = limit(now[n + SLIP_1], before[n + SLIP_1], ratio)
        c.slip_2[0] = limit(now[n + SLIP_2], before[n + SLIP_2], ratio)
        c.impulse = limit(now[n + IMPULSE], before[n + IMPULSE], ratio)
        c.impulse_1 = limit(now[n + IMPULSE_1], before[n + IMPULSE_1], ratio)
        c.impulse_2 = limit(now[n + IMPULSE_2], before[n + IMPULSE_2], ratio)
        c.final_slip = limit(now[n + FINAL_SLIP], before[n + FINAL_SLIP], ratio)
        c.restitution_loss = limit_of_loss(
            now[n + RESTITUTION_LOSS],
            before[n + RESTITUTION_LOSS],
            first[n + RESTITUTION_LOSS],
            ratio,
        )
        c.friction_loss = limit_of_loss(
            now[n + FRICTION_LOSS], before[n + FRICTION_LOSS], first[n + FRICTION_LOSS], ratio
        )
        if is_active(c):
            c.compression[0] = 0.0
            c.peak_compression = 0.0


@inner
def limit_of_loss(now: float, before: float, first: float, ratio: float) -> float:
    """
    Limit of an energy loss.

    If slip continues, a part of the loss in a cycle shrinks with the ratio, the rest with its
    square. Two cycles determine that part.
    """
    square = ratio * ratio
    change = now - before
    part = (change - square * (before - first)) / (1.0 - ratio)
    return now + part * ratio / (1.0 - ratio) + (change - part) * square / (1.0 - square)
