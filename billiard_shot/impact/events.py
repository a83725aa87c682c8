"""What can happen within a step: the first event on the step's polynomials, and the step's length."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.impact.friction import SLIDING, STICKING
from billiard_shot.impact.laws import POISSON
from billiard_shot.impact.polynomial import NO_ROOT, first_root
from billiard_shot.impact.series import COLUMNS

NOTHING = 0  # the step ends for accuracy's sake
TURN = 1  # compression ends, or begins anew
END = 2  # an active contact has finished restitution
JOIN = 3  # an inactive contact closes
SLIP_STOP = 4  # sliding has come to a stop
CONE = 5  # a sticking contact reaches the friction cone
EMPTY = 6  # law `poisson` only: the spring is empty before its impulse is complete

SLIP_KEPT = 0.2  # a step may not use up more of the slip: its series would step over zero unseen


@compiled
def step_size(
    friction: NDArray[np.float64],
    grip: NDArray[np.int64],
    active: NDArray[np.bool_],
    order: int,
    tolerance: float,
    u: NDArray[np.float64],
) -> float:
    """Length of a Taylor step, in units of its scale, from the last two coefficients of u."""
    last = 0.0
    before = 0.0
    for row in range(u.shape[0]):
        if row % 3 == 0 or friction[row // 3] > 0.0:
            last = max(last, abs(u[row, order]))
            before = max(before, abs(u[row, order - 1]))
    if not (last < 1e200 and before < 1e200):
        return 0.0
    x = 1e3
    if last > 0.0:
        x = min(x, (tolerance / last) ** (1.0 / order))
    if before > 0.0:
        x = min(x, (tolerance / before) ** (1.0 / (order - 1)))
    return 0.9 * x


@compiled
def cone_root(
    friction: float,
    force: NDArray[np.float64],
    order: int,
    end: float,
    work: NDArray[np.float64],
) -> float:
    """First x at which a sticking contact's force (rows N, x, y) leaves the friction cone."""
    normal = 0.0
    tangential = 0.0
    power = 1.0
    for k in range(order):
        normal += (abs(force[0, k]) if k == 0 else -abs(force[0, k])) * power
        tangential += (abs(force[1, k]) + abs(force[2, k])) * power
        power *= end
    if friction * normal > tangential or tangential == 0.0:
        return NO_ROOT
    c = work[2]
    for k in range(order):
        total = 0.0
        for i in range(k + 1):
            total += friction * friction * force[0, i] * force[0, k - i]
            total -= force[1, i] * force[1, k - i] + force[2, i] * force[2, k - i]
        c[k] = total
    on_rim = c[0] <= 1e-13 * (friction * force[0, 0]) ** 2
    return first_root(c, order - 1, 1.0, 0.0, on_rim, end, work)


@compiled
def slip_root(
    s: NDArray[np.float64],
    direction: NDArray[np.float64],
    order: int,
    kept: float,
    fired: bool,
    end: float,
    work: NDArray[np.float64],
) -> float:
    """First x at which the slip along its first direction has fallen to `kept`."""
    c = work[2]
    for k in range(order + 1):
        c[k] = s[0, k] * direction[0] + s[1, k] * direction[1]
    return first_root(c, order, 1.0, kept, fired, end, work)


@compiled
def impulse_root(
    remaining: float,
    scale: float,
    force: NDArray[np.float64],
    order: int,
    end: float,
    work: NDArray[np.float64],
) -> float:
    """First x at which a contact's normal impulse has grown by `remaining`."""
    c = work[2]
    c[0] = remaining
    for k in range(order):
        c[k + 1] = -scale * force[k] / (k + 1)
    return first_root(c, order, 1.0, 0.0, False, end, work)


@compiled
def first_event(
    law: int,
    friction: NDArray[np.float64],
    phase: NDArray[np.int64],
    grip: NDArray[np.int64],
    young: NDArray[np.bool_],
    straight: bool,
    direction: NDArray[np.float64],
    fired: NDArray[np.bool_],
    light: NDArray[np.bool_],
    heavy: NDArray[np.float64],
    goal: NDArray[np.float64],
    impulse: NDArray[np.float64],
    scale: float,
    order: int,
    end: float,
    u: NDArray[np.float64],
    y: NDArray[np.float64],
    force: NDArray[np.float64],
    work: NDArray[np.float64],
) -> tuple[float, int, int]:
    """
    Return (x, event, contact) of the first event in (0, end]; NOTHING at `end` where there is none.

    `fired[j]`: normal velocity and slip of contact j are exactly zero at the start; `goal`: the
    compression (law poisson: the impulse) at which restitution ends; `heavy`: the compression at
    which a light contact's force begins to count.
    """
    event = NOTHING
    contact = -1
    for j in range(friction.shape[0]):
        n = 3 * j
        if phase[j] == 0:
            x = first_root(u[n], order, 1.0, 0.0, fired[j, 0], end, work)
            if x != NO_ROOT:
                end, event, contact = x, JOIN, j
            continue
        sign = -1.0 if phase[j] == 1 else 1.0
        x = first_root(u[n], order, sign, 0.0, fired[j, 0], end, work)
        if x != NO_ROOT:
            end, event, contact = x, TURN, j
        if phase[j] == 2:
            if law == POISSON:
                x = impulse_root(goal[j] - impulse[n], scale, force[n], order, end, work)
                if x != NO_ROOT:
                    end, event, contact = x, END, j
                x = first_root(y[j], order, 1.0, 0.0, False, end, work)
                if x != NO_ROOT and (event != END or contact != j or x < end):
                    end, event, contact = x, EMPTY, j
            else:
                x = first_root(y[j], order, 1.0, goal[j], False, end, work)
                if x != NO_ROOT:
                    end, event, contact = x, END, j
        elif light[j]:
            x = first_root(y[j], order, -1.0, -heavy[j], False, end, work)
            if x != NO_ROOT:
                end, event, contact = x, NOTHING, j
        if grip[j] == SLIDING:
            slip = u[n + 1 : n + 3]
            kept = 0.0
            if not straight and not young[j]:
                kept = SLIP_KEPT * np.sqrt(slip[0, 0] ** 2 + slip[1, 0] ** 2)
            x = slip_root(slip, direction[2 * j : 2 * j + 2], order, kept, fired[j, 1], end, work)
            if x != NO_ROOT:
                end, event, contact = x, NOTHING if kept > 0.0 else SLIP_STOP, j
        elif grip[j] == STICKING:
            x = cone_root(friction[j], force[n : n + 3], order, end, work)
            if x != NO_ROOT:
                end, event, contact = x, CONE, j
    return end, event, contact
