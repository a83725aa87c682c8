"""The end of a step: the state moves to it, impulses and the work of friction are booked."""

from billiard_shot.compiled import frugal
from billiard_shot.impact.polynomial import evaluate
from billiard_shot.impact.state import FRICTIONLESS, INACTIVE, SLIDING, State

ROUNDING = 1e-14  # of velocities, in units of the largest


@frugal
def rubbing(s: State, j: int, order: int, x: float) -> float:
    """Integral from 0 to x of a sliding contact's friction times its slip, as a series."""
    fx, fy, ux, uy = s.force[3 * j + 1], s.force[3 * j + 2], s.u[3 * j + 1], s.u[3 * j + 2]
    total = 0.0
    power = x
    for n in range(order):
        product = 0.0
        for i in range(n + 1):
            product += fx[i] * ux[n - i] + fy[i] * uy[n - i]
        total += product * power / (n + 1)
        power *= x
    return total


@frugal
def advance(s: State, scale: float, order: int, x: float) -> None:
    """Move the state to x, and book the impulses and the work of friction."""
    for j in range(len(s.contact)):
        c = s.contact[j]
        n = 3 * j
        if c.phase == INACTIVE:
            continue
        for row in range(n, n + 3 if c.grip != FRICTIONLESS else n + 1):
            total = 0.0
            for k in range(order - 1, -1, -1):
                total = total * x + s.force[row, k] / (k + 1)
            s.impulse[row] += scale * x * total
        if c.grip == SLIDING:
            c.rubbed -= scale * rubbing(s, j, order, x)
    for row in range(s.u.shape[0]):
        s.u[row, 0] = evaluate(s.u[row], order, x)
    for j in range(len(s.contact)):
        c = s.contact[j]
        c.still = False
        c.onset = False
        if c.phase != INACTIVE:
            s.y[j, 0] = max(evaluate(s.y[j], order, x), 0.0)
        elif abs(s.u[3 * j, 0]) <= ROUNDING:
            s.u[3 * j, 0] = 0.0
            c.still = True
