"""
Coulomb friction at contacts without slip: which of them hold, and where the others begin to slide.

Frictionless contacts, sliding contacts (slip > 0) and sticking contacts obey linear relations
between forces; only the passage through zero slip needs a decision, and it is made here.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import frugal
from billiard_shot.impact.linear import pseudo_inverse
from billiard_shot.impact.polynomial import evaluate
from billiard_shot.impact.state import (
    FRICTIONLESS,
    INACTIVE,
    Model,
    Room,
    SLIDING,
    slip_speed,
    State,
    STICKING,
    stop_slip,
)

SWEEPS = 300


@frugal
def hold(m: Model, s: State, room: Room) -> None:
    """
    Eliminate the sticking contacts' friction: it is whatever keeps their slip at zero.

    With S the tangential components of the sticking contacts, 0 = W_SS F_S + W_S. F gives
    F_S = gain F (least norm where contacts share a constraint), and the contact velocities follow
    u' = effective F, effective = W + W_.S gain. Columns of S are zero: F holds the other forces.
    """
    size = m.response.shape[0]
    stuck = room.chosen
    count = 0
    for row in range(size):
        j = row // 3
        if row != 3 * j and s.contact[j].phase != INACTIVE and s.contact[j].grip == STICKING:
            stuck[count] = row
            count += 1
    for i in range(size):
        for j in range(size):
            s.effective[i, j] = m.response[i, j]
            s.gain[i, j] = 0.0
    if count == 0:
        return
    block, inverse = room.square[0, :count, :count], room.square[1, :count, :count]
    for a in range(count):
        for b in range(count):
            block[a, b] = m.response[stuck[a], stuck[b]]
    pseudo_inverse(block, inverse, room.square[2, :count, :count])
    for a in range(count):
        for j in range(size):
            for b in range(count):
                s.gain[stuck[a], j] -= inverse[a, b] * m.response[stuck[b], j]
    for a in range(count):
        for b in range(count):
            s.gain[stuck[a], stuck[b]] = 0.0
    for a in range(count):
        for j in range(size):
            if s.gain[stuck[a], j] != 0.0:
                for i in range(size):
                    s.effective[i, j] += m.response[i, stuck[a]] * s.gain[stuck[a], j]
    for a in range(count):
        for i in range(size):
            s.effective[i, stuck[a]] = 0.0
            s.effective[stuck[a], i] = 0.0


@frugal
def disc(
    axx: float, axy: float, ayy: float, bx: float, by: float, radius: float
) -> tuple[float, float]:
    """
    Minimise F.A.F/2 + b.F over the disc |F| <= radius, for a symmetric semidefinite 2x2 A.

    Inside, F = -A^-1 b: the contact holds. Else F = -(A + kappa)^-1 b with the one kappa >= 0 that
    puts it on the rim: the contact starts to slide along kappa F = -(A F + b).
    """
    if radius <= 0.0:
        return 0.0, 0.0
    mean, half = 0.5 * (axx + ayy), 0.5 * (axx - ayy)
    spread = np.sqrt(half * half + axy * axy)
    high, low = mean + spread, max(mean - spread, 0.0)
    angle = 0.5 * np.arctan2(axy, half)
    c, s = np.cos(angle), np.sin(angle)
    p, q = c * bx + s * by, -s * bx + c * by  # b in the principal axes
    kappa = 0.0
    tiny = 1e-14 * high
    inside = (p / max(high, 1e-300)) ** 2 + (q / max(low, tiny, 1e-300)) ** 2 <= radius * radius
    if not inside:
        size = np.sqrt(p * p + q * q)
        lower, upper = max(0.0, size / radius - high), size / radius
        kappa = max(lower, 0.0)
        for _ in range(60):  # Newton on 1/|F| - 1/radius, concave and increasing in kappa
            x, y = p / (high + kappa), q / (low + kappa)
            norm2 = x * x + y * y
            norm = np.sqrt(norm2)
            if norm > radius:
                lower = kappa
            else:
                upper = kappa
            slope = (x * x / (high + kappa) + y * y / (low + kappa)) / norm2
            step = (norm / radius - 1.0) / slope
            trial = kappa + step
            if not lower <= trial <= upper:
                trial = 0.5 * (lower + upper)
            if abs(trial - kappa) <= 1e-16 * (high + trial):
                kappa = trial
                break
            kappa = trial
    x = -p / max(high + kappa, 1e-300)
    y = -q / max(low + kappa, tiny if kappa == 0.0 else 1e-300)
    if not inside:
        norm = radius / np.sqrt(x * x + y * y)
        x *= norm
        y *= norm
    return c * x - s * y, s * x + c * y


@frugal
def slip_acceleration(
    m: Model, row: int, force: NDArray[np.float64], without: int
) -> tuple[float, float]:
    """Acceleration of one contact velocity under the forces, and its rounding scale."""
    total = 0.0
    scale = 0.0
    for i in range(force.shape[0]):
        if i != without and i != without + 1:
            total += m.response[row, i] * force[i]
            scale += abs(m.response[row, i] * force[i])
    return total, scale


@frugal
def balance(m: Model, s: State, force: NDArray[np.float64]) -> None:
    """
    Find the friction of the contacts without slip, given the normal and the sliding forces.

    Gauss's principle of least constraint: among the friction forces inside their discs, the real
    ones minimise F.W.F/2 + b.F (a convex problem, b the slip acceleration without them). Solved
    contact by contact until nothing moves.
    """
    largest = 0.0
    for i in range(force.shape[0]):
        largest = max(largest, abs(force[i]))
    for _ in range(SWEEPS):
        moved = 0.0
        for j in range(len(s.contact)):
            c = s.contact[j]
            if c.phase != INACTIVE and c.grip == STICKING:
                x, y = 3 * j + 1, 3 * j + 2
                bx, _scale = slip_acceleration(m, x, force, x)
                by, _scale = slip_acceleration(m, y, force, x)
                fx, fy = disc(
                    m.response[x, x],
                    m.response[x, y],
                    m.response[y, y],
                    bx,
                    by,
                    c.friction * force[3 * j],
                )
                moved = max(moved, abs(fx - force[x]), abs(fy - force[y]))
                force[x], force[y] = fx, fy
        if moved <= 1e-16 * largest:
            break


@frugal
def release(m: Model, s: State, force: NDArray[np.float64], noise: float, start: bool) -> bool:
    """
    Whether any contact without slip cannot hold under the forces that `balance` found.

    With `start`, those that cannot become SLIDING, at their onset, along their acceleration.
    """
    any_starts = False
    for j in range(len(s.contact)):
        c = s.contact[j]
        if c.phase != INACTIVE and c.grip == STICKING:
            x, y = 3 * j + 1, 3 * j + 2
            ax, scale_x = slip_acceleration(m, x, force, -2)
            ay, scale_y = slip_acceleration(m, y, force, -2)
            size = np.sqrt(ax * ax + ay * ay)
            used = np.sqrt(force[x] * force[x] + force[y] * force[y])
            rim = c.friction * force[3 * j]
            if used >= rim * (1.0 - 1e-12) and size > noise * (scale_x + scale_y):
                any_starts = True
                if start:
                    c.onset = True
                    c.toward_x = ax / size
                    c.toward_y = ay / size
    if start:
        for j in range(len(s.contact)):
            c = s.contact[j]
            if c.onset and c.grip == STICKING:
                c.grip = SLIDING
                c.young = not m.straight
    return any_starts


@frugal
def let_go(m: Model, s: State, room: Room, j: int) -> None:
    """
    Let a sticking contact begin to slide along its `direction`, if the other contacts allow it.

    Contacts that share a constraint may hold one of them in place although its own part of the
    friction (least norm) is beyond its cone. They hold as long as any division of friction can.
    """
    c = s.contact[j]
    c.grip = SLIDING
    hold(m, s, room)
    x, y = 3 * j + 1, 3 * j + 2
    yields = max(s.effective[x, x], s.effective[y, y])
    if yields > 1e-9 * max(m.response[x, x], m.response[y, y]):
        stop_slip(s, j)
        c.onset = True
        c.young = not m.straight
    else:
        c.grip = STICKING
        c.pinned = True
        hold(m, s, room)


@frugal
def holds(m: Model, s: State, room: Room, order: int, x: float) -> bool:
    """Whether any division of friction keeps the contacts without slip in place at x."""
    force = room.push[0]
    for row in range(force.shape[0]):
        active = s.contact[row // 3].phase != INACTIVE
        force[row] = evaluate(s.force[row], order - 1, x) if active else 0.0
    balance(m, s, force)
    return not release(m, s, force, 1e-9, False)


@frugal
def settle(m: Model, s: State, room: Room, least: float) -> None:
    """
    Give every active contact its mode of friction, and eliminate the friction of those that stick.

    Contacts that slide keep sliding. The others hold or start to slide as the forces of this
    moment ask, or, where all springs are still empty, those of the next moment. Slip up to `least`
    is none.
    """
    count = len(s.contact)
    force = room.push[0]
    for row in range(3 * count):
        force[row] = 0.0
    loaded = False
    waiting = False
    for j in range(count):
        loaded = loaded or (s.contact[j].phase != INACTIVE and s.y[j, 0] > 0.0)
    for j in range(count):
        c = s.contact[j]
        if c.phase == INACTIVE:
            c.young = False
            c.onset = False
            continue
        pressed = s.y[j, 0] if loaded else max(-s.u[3 * j, 0], 0.0)
        c.pinned = False
        force[3 * j] = c.stiffness * pressed**m.exponent
        if c.friction == 0.0 or c.idle:
            c.grip = FRICTIONLESS
            continue
        slip = slip_speed(s, j)
        if slip > least:
            c.grip = SLIDING
            c.toward_x = s.u[3 * j + 1, 0] / slip
            c.toward_y = s.u[3 * j + 2, 0] / slip
        elif not c.onset:
            stop_slip(s, j)
            c.grip = STICKING
            c.young = False
            waiting = True
        if c.grip == SLIDING:
            force[3 * j + 1] = -c.friction * force[3 * j] * c.toward_x
            force[3 * j + 2] = -c.friction * force[3 * j] * c.toward_y
    if waiting:
        balance(m, s, force)
        release(m, s, force, 1e-12, True)
    hold(m, s, room)
