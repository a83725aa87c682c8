"""
The last moments of a slip: so short that all else stands still, and the slip alone moves.

As its slip goes to zero, a contact's friction may turn ever faster, and steps along the motion
shrink with the slip. But once the time that is left is short against the tolerance, the normal
forces and the friction elsewhere are constant over it, and what remains is a problem in the plane,
    u' = b - f A d,   d = u / |u|,
b the slip acceleration without the contact's own friction, f = mu N its limit, A its response. In
the time sigma with d tau = |u| d sigma it is smooth: u_sigma = |u| b - f A u. The slip either
comes to rest or, where friction cannot hold it, passes by zero and grows again.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import frugal
from billiard_shot.impact.laws import POISSON
from billiard_shot.impact.state import (
    INACTIVE,
    Model,
    RESTORING,
    Room,
    SLIDING,
    slip_speed,
    State,
    STICKING,
    stop_slip,
)

MOVES, STOPPED, PASSED = 0, 1, 2
STEPS = 400  # of the plane problem; a slip that takes more hardly slows down
APART = 0.05  # slip against that of other contacts; contacts of like slip stop together
MARGIN = 2.0  # distance to all other events, in units of what the moment could change


@frugal
def loner(s: State) -> int:
    """Contact that slides much slower than all others, or -1."""
    found = -1
    least = np.inf
    second = np.inf
    for j in range(len(s.contact)):
        if s.contact[j].grip == SLIDING and not s.contact[j].onset:
            speed = slip_speed(s, j)
            second = min(second, max(speed, least))
            if speed < least:
                found, least = j, speed
    return found if least < APART * second else -1


@frugal
def unrest(m: Model, s: State, scale: float, j: int) -> float:
    """Bound of how fast the acceleration of any contact velocity changes while contact j stops."""
    largest = 0.0
    for row in range(s.u.shape[0]):
        total = 0.0
        for k in range(len(s.contact)):
            c = s.contact[k]
            if c.phase == INACTIVE:
                continue
            n = 3 * k
            normal = abs(s.effective[row, n])
            across = abs(s.effective[row, n + 1]) + abs(s.effective[row, n + 2])
            growth = m.exponent * c.rate * abs(s.u[n, 0])
            growth *= c.stiffness * s.y[k, 0] ** (m.exponent - 1.0)
            total += normal * growth
            if c.grip == SLIDING:
                total += across * c.friction * growth
                if k != j:
                    turning = (abs(s.u[n + 1, 1]) + abs(s.u[n + 2, 1])) / scale
                    turning /= max(slip_speed(s, k), 1e-300)
                    total += across * c.friction * s.force[n, 0] * turning
        largest = max(largest, total)
    return largest


@frugal
def is_quiet(m: Model, s: State, scale: float, j: int, time: float) -> bool:
    """Whether nothing else can happen while contact j's slip ends, within `time`."""
    rim = s.contact[j].friction * s.force[3 * j, 0]
    for k in range(len(s.contact)):
        c = s.contact[k]
        n = 3 * k
        drift = 0.0  # of the normal velocity
        for column in range(3 * j + 1, 3 * j + 3):
            drift += 2.0 * abs(s.effective[n, column]) * rim
        drift = MARGIN * time * (drift + abs(s.u[n, 1]) / scale)
        opening = s.u[n, 0]
        if c.phase == INACTIVE:
            if -drift <= opening <= drift and (drift > 0.0 or opening < 0.0):
                return False
            continue
        if abs(opening) <= drift:
            return False
        if c.phase == RESTORING:
            goal = 0.0 if m.law == POISSON else c.goal
            if m.law == POISSON:
                left = c.goal - s.impulse[n]
                if left <= MARGIN * time * s.force[n, 0]:
                    return False
            if s.y[k, 0] - goal <= MARGIN * time * c.rate * (abs(opening) + drift):
                return False
        if c.pinned:
            return False
        if c.grip == STICKING:
            room = c.friction * s.force[n, 0]
            fx, fy = s.force[n + 1, 0], s.force[n + 2, 0]
            swing = 0.0
            for row in range(n + 1, n + 3):
                for column in range(3 * j + 1, 3 * j + 3):
                    swing += 2.0 * abs(s.gain[row, column]) * rim
            if np.sqrt(fx * fx + fy * fy) + swing >= 0.999 * room:
                return False
    return True


@frugal
def coast(
    axx: float,
    axy: float,
    ayy: float,
    bx: float,
    by: float,
    ux: float,
    uy: float,
    tolerance: float,
) -> tuple[float, float, float, float]:
    """
    Follow u' = b - A u/|u| until |u| is zero or as large as it was.

    Returns the time (negative where that takes too many steps), the integrals over it of u/|u|
    (2) and of |u|. Classical Runge-Kutta steps in sigma, as accurate as `tolerance` asks.
    """
    first = np.sqrt(ux * ux + uy * uy)
    pace = axx + ayy + np.sqrt(bx * bx + by * by)
    time, px, py, path = 0.0, 0.0, 0.0, 0.0
    speed = first
    for _ in range(STEPS):
        h = min(max(1.5 * (tolerance / speed) ** 0.25, 0.02), 0.5) / pace
        x, y, r = ux, uy, speed
        dx, dy, dt, dq = 0.0, 0.0, 0.0, 0.0
        gx, gy = 0.0, 0.0
        for stage in range(4):
            kx, ky = r * bx - axx * x - axy * y, r * by - axy * x - ayy * y
            weight = h / 6.0 if stage in (0, 3) else h / 3.0
            dx += weight * kx
            dy += weight * ky
            dt += weight * r
            dq += weight * r * r
            gx += weight * x
            gy += weight * y
            reach = h if stage == 2 else 0.5 * h
            x, y = ux + reach * kx, uy + reach * ky
            r = np.sqrt(x * x + y * y)
        ux += dx
        uy += dy
        time += dt
        px += gx
        py += gy
        path += dq
        speed = np.sqrt(ux * ux + uy * uy)
        if speed >= first:
            return time, px, py, path
        # On the line through zero: where the direction is steady, the rest is one more stretch.
        vx, vy = speed * bx - axx * ux - axy * uy, speed * by - axy * ux - ayy * uy
        slowing = -(ux * vx + uy * vy) / (speed * speed)
        turning = (ux * vy - uy * vx) / (speed * speed)
        if slowing > 0.0 and speed * (turning / slowing) ** 2 <= 0.1 * tolerance:
            rest = speed / slowing
            time += rest
            return time, px + rest * ux / speed, py + rest * uy / speed, path + 0.5 * rest * speed
        if speed < 1e-3 * tolerance:
            return time, px, py, path
    return -1.0, 0.0, 0.0, 0.0


@frugal
def stand(m: Model, s: State, room: Room, scale: float, length: float, tolerance: float) -> int:
    """
    Take the one slowest slip to its stop, or past zero, if nothing else changes meanwhile.

    The step's coefficients 0 and 1 are known, and its `length` in units of its scale. Returns
    MOVES (nothing done), STOPPED or PASSED.
    """
    j = loner(s)
    if j < 0 or s.force[3 * j, 0] <= 0.0:
        return MOVES
    n, x, y = 3 * j, 3 * j + 1, 3 * j + 2
    ux, uy = s.u[x, 0], s.u[y, 0]
    slip = np.sqrt(ux * ux + uy * uy)
    if ux * s.u[x, 1] + uy * s.u[y, 1] >= 0.0:
        return MOVES  # it grows
    change = unrest(m, s, scale, j)
    pace = np.sqrt(s.u[x, 1] ** 2 + s.u[y, 1] ** 2) / scale
    if 4.0 * change * (slip / pace) ** 2 > tolerance:
        return MOVES
    rim = s.contact[j].friction * s.force[n, 0]
    axx, axy, ayy = (
        rim * s.effective[x, x],
        rim * s.effective[x, y],
        rim * s.effective[y, y],
    )
    dx, dy = ux / slip, uy / slip
    bx = s.u[x, 1] / scale + axx * dx + axy * dy
    by = s.u[y, 1] / scale + axy * dx + ayy * dy
    time, px, py, path = coast(axx, axy, ayy, bx, by, ux, uy, tolerance)
    if time < 0.0 or 4.0 * change * time * time > tolerance:
        return MOVES
    if not is_quiet(m, s, scale, j, time):
        return MOVES
    # The integral p of u/|u| says where the slip ends: at u + b time - A p; at zero, exactly.
    wx, wy = ux + bx * time, uy + by * time
    stops = np.hypot(wx - axx * px - axy * py, wy - axy * px - ayy * py) < 0.5 * slip
    if stops:
        determinant = axx * ayy - axy * axy
        if not determinant > 1e-9 * axx * ayy:
            return MOVES
        px, py = (ayy * wx - axy * wy) / determinant, (axx * wy - axy * wx) / determinant
    elif time < length * scale:
        return MOVES  # a step along the motion gets further
    leave(s, room.push[0], j, time, px, py, path)
    if not stops:
        return PASSED
    stop_slip(s, j)
    return STOPPED


@frugal
def leave(
    s: State, push: NDArray[np.float64], j: int, time: float, px: float, py: float, path: float
) -> None:
    """Apply the impulses of constant forces over `time`, contact j's friction along p."""
    size = s.u.shape[0]
    for row in range(size):
        push[row] = 0.0
    for k in range(len(s.contact)):
        c = s.contact[k]
        if c.phase != INACTIVE:
            n = 3 * k
            push[n] = time * s.force[n, 0]
            if k == j:
                push[n + 1] = -s.contact[j].friction * s.force[n, 0] * px
                push[n + 2] = -s.contact[j].friction * s.force[n, 0] * py
            elif c.grip == SLIDING:
                push[n + 1] = time * s.force[n + 1, 0]
                push[n + 2] = time * s.force[n + 2, 0]
    for k in range(len(s.contact)):
        c = s.contact[k]
        n = 3 * k
        c.still = False
        c.onset = False
        for row in range(n, n + 3 if s.contact[k].friction > 0.0 else n + 1):
            change = 0.0
            held = 0.0
            for column in range(size):
                change += s.effective[row, column] * push[column]
                held += s.gain[row, column] * push[column]
            if row == n and c.phase != INACTIVE:
                s.y[k, 0] -= time * c.rate * (s.u[n, 0] + 0.5 * change)
            elif row > n and c.grip == SLIDING and k != j:
                c.rubbed -= push[row] * (s.u[row, 0] + 0.5 * change)
            s.u[row, 0] += change
            s.impulse[row] += push[row] + held
    s.contact[j].rubbed += s.contact[j].friction * s.force[3 * j, 0] * path
