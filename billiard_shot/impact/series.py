"""
One step of a collision as a Taylor series: all forces and contact velocities, order by order.

Powers of y and 1/|slip| follow from recurrences (Knuth, The Art of Computer Programming, vol. 2,
section 4.7), so that a step of any order costs one pass of convolutions.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.impact.state import INACTIVE, SLIDING, STICKING, Model, State


@compiled
def normal_coefficient(
    y: NDArray[np.float64], n: NDArray[np.float64], k: int, stiffness: float, exponent: float
) -> float:
    """Coefficient k of N = stiffness * y**exponent from y[0..k] and n[0..k-1]."""
    if exponent == 1.0:
        return stiffness * y[k]
    if k == 0:
        return stiffness * y[0] ** exponent
    total = 0.0
    for i in range(1, k + 1):
        total += (exponent * i - (k - i)) * y[i] * n[k - i]
    return total / (k * y[0])


@compiled
def slide_coefficient(s: State, contact: int, k: int, friction: float) -> None:
    """Coefficient k of the sliding friction -friction N slip/|slip|, N being known to order k."""
    n = 3 * contact
    q, r = s.work[4 * contact], s.work[4 * contact + 1]  # slip.slip and 1/|slip|
    dx, dy = s.work[4 * contact + 2], s.work[4 * contact + 3]  # slip/|slip|
    sx, sy, normal = s.u[n + 1], s.u[n + 2], s.force[n]
    total = 0.0
    for i in range(k + 1):
        total += sx[i] * sx[k - i] + sy[i] * sy[k - i]
    q[k] = total
    if k == 0:
        r[0] = 1.0 / np.sqrt(total)
    else:
        total = 0.0
        for i in range(1, k + 1):
            total += (0.5 * i - k) * q[i] * r[k - i]
        r[k] = total / (k * q[0])
    x = 0.0
    y = 0.0
    for i in range(k + 1):
        x += sx[i] * r[k - i]
        y += sy[i] * r[k - i]
    dx[k] = x
    dy[k] = y
    x = 0.0
    y = 0.0
    for i in range(k + 1):
        x += normal[i] * dx[k - i]
        y += normal[i] * dy[k - i]
    s.force[n + 1, k] = -friction * x
    s.force[n + 2, k] = -friction * y


@compiled
def expand(m: Model, s: State, scale: float, order: int) -> None:
    """Fill the step's coefficients: force[:, :order], u and y[:, :order + 1], from column 0."""
    count = m.friction.shape[0]
    for k in range(order):
        for j in range(count):
            if s.phase[j] == INACTIVE:
                continue
            n = 3 * j
            if s.light[j]:
                s.force[n, k] = 0.0
            else:
                s.force[n, k] = normal_coefficient(
                    s.y[j], s.force[n], k, m.stiffness[j], m.exponent
                )
            if s.grip[j] == SLIDING:
                if m.straight:
                    s.force[n + 1, k] = -m.friction[j] * s.force[n, k] * s.direction[j, 0]
                    s.force[n + 2, k] = -m.friction[j] * s.force[n, k] * s.direction[j, 1]
                else:
                    slide_coefficient(s, j, k, m.friction[j])
        integrate(m, s, scale, k)
    lean(s, order, s.force)


@compiled
def integrate(m: Model, s: State, scale: float, k: int) -> None:
    """Coefficients k + 1 of u and y from coefficients k: u' = W F, y' = -rate u_n."""
    count = m.friction.shape[0]
    factor = scale / (k + 1)
    for row in range(3 * count):
        if row % 3 != 0 and m.friction[row // 3] == 0.0:
            continue
        total = 0.0
        for j in range(count):
            if s.phase[j] != INACTIVE:
                total += s.effective[row, 3 * j] * s.force[3 * j, k]
                if s.grip[j] == SLIDING:
                    total += s.effective[row, 3 * j + 1] * s.force[3 * j + 1, k]
                    total += s.effective[row, 3 * j + 2] * s.force[3 * j + 2, k]
        s.u[row, k + 1] = factor * total
    for j in range(count):
        if s.phase[j] != INACTIVE:
            s.y[j, k + 1] = -s.rate[j] * factor * s.u[3 * j, k]


@compiled
def lean(s: State, columns: int, force: NDArray[np.float64]) -> None:
    """Fill in the friction of the sticking contacts, gain F, in the leading columns of `force`."""
    count = s.phase.shape[0]
    for j in range(count):
        if s.phase[j] == INACTIVE or s.grip[j] != STICKING:
            continue
        for row in range(3 * j + 1, 3 * j + 3):
            for k in range(columns):
                force[row, k] = 0.0
            for column in range(3 * count):
                i = column // 3
                if s.gain[row, column] != 0.0 and s.phase[i] != INACTIVE:
                    if column == 3 * i or s.grip[i] == SLIDING:
                        for k in range(columns):
                            force[row, k] += s.gain[row, column] * force[column, k]


@compiled
def step_size(m: Model, s: State, order: int, tolerance: float) -> float:
    """Length of a Taylor step in units of its scale, from u's last two coefficients; 0: overflow."""
    last = 0.0
    before = 0.0
    for row in range(s.u.shape[0]):
        if row % 3 == 0 or m.friction[row // 3] > 0.0:
            last = max(last, abs(s.u[row, order]))
            before = max(before, abs(s.u[row, order - 1]))
    if not (last < 1e200 and before < 1e200):
        return 0.0
    x = 1e3
    if last > 0.0:
        x = min(x, (tolerance / last) ** (1.0 / order))
    if before > 0.0:
        x = min(x, (tolerance / before) ** (1.0 / (order - 1)))
    return 0.9 * x
