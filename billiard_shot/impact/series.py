"""
One step of a collision as a Taylor series: all forces and contact velocities, order by order.

Within a step the state is u(x), y(x) with x = time / scale. Powers of y and 1/|slip| follow from
recurrences (Knuth, TAOCP vol. 2, 4.7), so that a step of any order costs one pass of convolutions.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.impact.friction import SLIDING

COLUMNS = 26  # room for the highest order's coefficients


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
def slide_coefficient(
    s: NDArray[np.float64],
    q: NDArray[np.float64],
    r: NDArray[np.float64],
    d: NDArray[np.float64],
    force: NDArray[np.float64],
    k: int,
    friction: float,
) -> None:
    """
    Coefficient k of the sliding friction force = -friction N s/|s|.

    s, d: rows of two components; q = s.s, r = 1/|s|, d = s r; force: rows N, x, y, of which N is
    known to order k.
    """
    total = 0.0
    for i in range(k + 1):
        total += s[0, i] * s[0, k - i] + s[1, i] * s[1, k - i]
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
        x += s[0, i] * r[k - i]
        y += s[1, i] * r[k - i]
    d[0, k] = x
    d[1, k] = y
    x = 0.0
    y = 0.0
    for i in range(k + 1):
        x += force[0, i] * d[0, k - i]
        y += force[0, i] * d[1, k - i]
    force[1, k] = -friction * x
    force[2, k] = -friction * y


@compiled
def expand(
    effective: NDArray[np.float64],
    gain: NDArray[np.float64],
    friction: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    exponent: float,
    rate: NDArray[np.float64],
    active: NDArray[np.bool_],
    grip: NDArray[np.int64],
    light: NDArray[np.bool_],
    straight: bool,
    direction: NDArray[np.float64],
    scale: float,
    order: int,
    u: NDArray[np.float64],
    y: NDArray[np.float64],
    force: NDArray[np.float64],
    work: NDArray[np.float64],
) -> None:
    """
    Fill the coefficients: force[:, :order], u[:, :order + 1], y[:, :order + 1], from column 0 of u and y.

    `rate`: of the springs (law); `light`: contacts whose force is still negligible (exponent > 1);
    `straight`: all slip keeps its `direction`; work: (4 N, columns).
    """
    count = friction.shape[0]
    for k in range(order):
        for j in range(count):
            if not active[j]:
                continue
            n = 3 * j
            if light[j]:
                force[n, k] = 0.0
            else:
                force[n, k] = normal_coefficient(y[j], force[n], k, stiffness[j], exponent)
            if grip[j] == SLIDING:
                if straight:
                    force[n + 1, k] = -friction[j] * force[n, k] * direction[2 * j]
                    force[n + 2, k] = -friction[j] * force[n, k] * direction[2 * j + 1]
                else:
                    slide_coefficient(
                        u[n + 1 : n + 3], work[4 * j], work[4 * j + 1], work[4 * j + 2 : 4 * j + 4],
                        force[n : n + 3], k, friction[j],
                    )
        accelerate(effective, friction, active, grip, scale, k, u, force)
        for j in range(count):
            if active[j]:
                y[j, k + 1] = -rate[j] * scale * u[3 * j, k] / (k + 1)
    lean(gain, friction, active, grip, order, force)


@compiled
def accelerate(
    effective: NDArray[np.float64],
    friction: NDArray[np.float64],
    active: NDArray[np.bool_],
    grip: NDArray[np.int64],
    scale: float,
    k: int,
    u: NDArray[np.float64],
    force: NDArray[np.float64],
) -> None:
    """Coefficient k + 1 of the contact velocities from coefficient k of the forces: u' = W F."""
    count = friction.shape[0]
    factor = scale / (k + 1)
    for row in range(3 * count):
        if row % 3 != 0 and friction[row // 3] == 0.0:
            continue
        total = 0.0
        for j in range(count):
            if active[j]:
                total += effective[row, 3 * j] * force[3 * j, k]
                if grip[j] == SLIDING:
                    total += effective[row, 3 * j + 1] * force[3 * j + 1, k]
                    total += effective[row, 3 * j + 2] * force[3 * j + 2, k]
        u[row, k + 1] = factor * total


@compiled
def lean(
    gain: NDArray[np.float64],
    friction: NDArray[np.float64],
    active: NDArray[np.bool_],
    grip: NDArray[np.int64],
    order: int,
    force: NDArray[np.float64],
) -> None:
    """Fill in the friction of the sticking contacts: F_S = gain F."""
    count = friction.shape[0]
    for j in range(count):
        if active[j] and grip[j] != SLIDING and friction[j] > 0.0:
            for row in range(3 * j + 1, 3 * j + 3):
                for k in range(order):
                    force[row, k] = 0.0
                for i in range(count):
                    if active[i]:
                        for column in range(3 * i, 3 * i + (3 if grip[i] == SLIDING else 1)):
                            factor = gain[row, column]
                            if factor != 0.0:
                                for k in range(order):
                                    force[row, k] += factor * force[column, k]
