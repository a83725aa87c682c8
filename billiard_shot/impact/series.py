"""
One step of a collision as a Taylor series: all forces and contact velocities, order by order.

Powers of y and the direction of slip follow from recurrences (Knuth, The Art of Computer
Programming, vol. 2, section 4.7): a step of any order costs one pass of convolutions.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import frugal, melted
from billiard_shot.impact.state import INACTIVE, Model, SLIDING, State, STICKING


@melted
def normal_coefficient(
    y: NDArray[np.float64],
    force: NDArray[np.float64],
    contact: int,
    k: int,
    stiffness: float,
    exponent: float,
) -> float:
    """Coefficient k of N = stiffness * y**exponent, from y to order k and N to order k - 1."""
    if exponent == 1.0:
        return stiffness * y[contact, k]
    if k == 0:
        return stiffness * y[contact, 0] ** exponent
    total = 0.0
    for i in range(1, k + 1):
        total += (exponent * i - (k - i)) * y[contact, i] * force[3 * contact, k - i]
    return total / (k * y[contact, 0])


@melted
def slide_coefficient(
    u: NDArray[np.float64],
    force: NDArray[np.float64],
    work: NDArray[np.float64],
    contact: int,
    k: int,
    friction: float,
) -> None:
    """
    Coefficient k of the sliding friction -friction N d, with slip = rho d and N known to order k.

    rho' = d.slip' gives k rho_k from the lower orders of d, then rho d = slip gives d_k. The rows
    3 contact ... of work hold rho and d.
    """
    n, x, y = 3 * contact, 3 * contact + 1, 3 * contact + 2
    if k == 0:
        work[n, 0] = np.sqrt(u[x, 0] * u[x, 0] + u[y, 0] * u[y, 0])
    growth = 0.0
    rest_x, rest_y = u[x, k], u[y, k]
    push_x, push_y = 0.0, 0.0
    for i in range(1, k):
        dx, dy = work[x, k - i], work[y, k - i]
        growth += i * (u[x, i] * dx + u[y, i] * dy)
        rest_x -= work[n, i] * dx
        rest_y -= work[n, i] * dy
        push_x += force[n, i] * dx
        push_y += force[n, i] * dy
    if k > 0:
        dx, dy = work[x, 0], work[y, 0]
        rho = growth / k + u[x, k] * dx + u[y, k] * dy
        work[n, k] = rho
        rest_x -= rho * dx
        rest_y -= rho * dy
        push_x += force[n, k] * dx
        push_y += force[n, k] * dy
    work[x, k] = rest_x / work[n, 0]
    work[y, k] = rest_y / work[n, 0]
    force[x, k] = -friction * (push_x + force[n, 0] * work[x, k])
    force[y, k] = -friction * (push_y + force[n, 0] * work[y, k])


@melted
def expand(m: Model, s: State, scale: float, order: int) -> None:
    """Fill the step's coefficients: force[:, :order], u and y[:, :order + 1], from column 0."""
    u, y, force, work, exponent = s.u, s.y, s.force, s.work, m.exponent
    for k in range(order):
        for j in range(len(s.contact)):
            c = s.contact[j]
            if c.phase == INACTIVE:
                continue
            n = 3 * j
            if c.light:
                force[n, k] = 0.0
            else:
                force[n, k] = normal_coefficient(y, force, j, k, c.stiffness, exponent)
            if c.grip == SLIDING:
                if m.straight:
                    force[n + 1, k] = -c.friction * force[n, k] * c.toward_x
                    force[n + 2, k] = -c.friction * force[n, k] * c.toward_y
                else:
                    slide_coefficient(u, force, work, j, k, c.friction)
        integrate(s, scale, k)
    lean(s, order, force)


@melted
def integrate(s: State, scale: float, k: int) -> None:
    """Coefficients k + 1 of u and y from coefficients k: u' = W F, y' = -rate u_n."""
    u, y, force, effective = s.u, s.y, s.force, s.effective
    count = len(s.contact)
    factor = scale / (k + 1)
    for i in range(count):
        for row in range(3 * i, 3 * i + 3 if s.contact[i].friction > 0.0 else 3 * i + 1):
            total = 0.0
            for j in range(count):
                c = s.contact[j]
                if c.phase != INACTIVE:
                    total += effective[row, 3 * j] * force[3 * j, k]
                    if c.grip == SLIDING:
                        total += effective[row, 3 * j + 1] * force[3 * j + 1, k]
                        total += effective[row, 3 * j + 2] * force[3 * j + 2, k]
            u[row, k + 1] = factor * total
    for j in range(count):
        c = s.contact[j]
        if c.phase != INACTIVE:
            y[j, k + 1] = -c.rate * factor * u[3 * j, k]


@frugal
def lean(s: State, columns: int, force: NDArray[np.float64]) -> None:
    """Fill in the friction of the sticking contacts, gain F, in the leading columns of `force`."""
    count = len(s.contact)
    for j in range(count):
        if s.contact[j].phase == INACTIVE or s.contact[j].grip != STICKING:
            continue
        for row in range(3 * j + 1, 3 * j + 3):
            for k in range(columns):
                force[row, k] = 0.0
            for i in range(count):
                c = s.contact[i]
                if c.phase != INACTIVE:
                    for column in range(3 * i, 3 * i + (3 if c.grip == SLIDING else 1)):
                        factor = s.gain[row, column]
                        for k in range(columns):
                            force[row, k] += factor * force[column, k]


@melted
def step_size(m: Model, s: State, order: int, tolerance: float) -> float:
    """Length of a step in units of its scale, from u's last two coefficients; 0: overflow."""
    last = 0.0
    before = 0.0
    for row in range(s.u.shape[0]):
        if row % 3 == 0 or s.contact[row // 3].friction > 0.0:
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
