"""
Coulomb friction at contacts without slip: which of them hold, and where the others begin to slide.

Frictionless contacts, sliding contacts (slip > 0) and sticking contacts obey linear relations between
forces; only the passage through zero slip needs a decision, and all of it is made here.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.impact.linear import pseudo_inverse

FRICTIONLESS, SLIDING, STICKING = 0, 1, 2


@compiled
def hold(
    response: NDArray[np.float64],
    grip: NDArray[np.int64],
    active: NDArray[np.bool_],
    effective: NDArray[np.float64],
    gain: NDArray[np.float64],
) -> None:
    """
    Eliminate the sticking contacts' friction: it is whatever keeps their slip at zero.

    With S the tangential components of the sticking contacts, 0 = W_SS F_S + W_S. F gives
    F_S = gain F (least norm where contacts share a constraint), and the contact velocities follow
    u' = effective F, effective = W + W_.S gain. Columns of S are zero: F holds the other forces.
    """
    size = response.shape[0]
    stuck = np.empty(size, np.int64)
    count = 0
    for j in range(size // 3):
        if active[j] and grip[j] == STICKING:
            stuck[count] = 3 * j + 1
            stuck[count + 1] = 3 * j + 2
            count += 2
    for i in range(size):
        for j in range(size):
            effective[i, j] = response[i, j]
            gain[i, j] = 0.0
    if count == 0:
        return
    block = np.empty((count, count))
    inverse = np.empty((count, count))
    for a in range(count):
        for b in range(count):
            block[a, b] = response[stuck[a], stuck[b]]
    pseudo_inverse(block, count, inverse)
    for a in range(count):
        for j in range(size):
            for b in range(count):
                gain[stuck[a], j] -= inverse[a, b] * response[stuck[b], j]
    for a in range(count):
        for b in range(count):
            gain[stuck[a], stuck[b]] = 0.0
    for j in range(size):
        for a in range(count):
            if gain[stuck[a], j] != 0.0:
                for i in range(size):
                    effective[i, j] += response[i, stuck[a]] * gain[stuck[a], j]
    for a in range(count):
        for i in range(size):
            effective[i, stuck[a]] = 0.0
            effective[stuck[a], i] = 0.0


@compiled
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


@compiled
def release(
    response: NDArray[np.float64],
    friction: NDArray[np.float64],
    grip: NDArray[np.int64],
    active: NDArray[np.bool_],
    normal: NDArray[np.float64],
    direction: NDArray[np.float64],
    onset: NDArray[np.bool_],
) -> None:
    """
    Decide which of the contacts without slip hold, and in which direction the others start.

    Gauss's principle of least constraint: among the friction forces inside their discs, the real
    ones minimise F.W.F/2 + b.F (a convex problem, b the slip acceleration without them). Solved
    contact by contact until nothing moves. `normal`: the normal forces (or, where all are still
    zero, their rates). Contacts that start to slide become SLIDING, with `onset` set.
    """
    count = friction.shape[0]
    force = np.zeros(3 * count)
    waiting = 0
    for j in range(count):
        if active[j]:
            force[3 * j] = normal[j]
            if grip[j] == SLIDING:
                force[3 * j + 1] = -friction[j] * normal[j] * direction[2 * j]
                force[3 * j + 2] = -friction[j] * normal[j] * direction[2 * j + 1]
            elif grip[j] == STICKING:
                waiting += 1
    size = 0.0
    for i in range(3 * count):
        size = max(size, abs(force[i]))
    bx = 0.0
    by = 0.0
    for sweep in range(2000):
        moved = 0.0
        for j in range(count):
            if active[j] and grip[j] == STICKING:
                x, y = 3 * j + 1, 3 * j + 2
                old_x, old_y = force[x], force[y]
                force[x] = 0.0
                force[y] = 0.0
                bx = 0.0
                by = 0.0
                for i in range(3 * count):
                    bx += response[x, i] * force[i]
                    by += response[y, i] * force[i]
                force[x], force[y] = disc(
                    response[x, x], response[x, y], response[y, y], bx, by, friction[j] * normal[j]
                )
                moved = max(moved, abs(force[x] - old_x), abs(force[y] - old_y))
        if moved <= 1e-16 * size or (waiting == 1 and sweep == 0):
            break
    for j in range(count):
        if active[j] and grip[j] == STICKING:
            x, y = 3 * j + 1, 3 * j + 2
            ax = 0.0
            ay = 0.0
            noise = 0.0
            for i in range(3 * count):
                ax += response[x, i] * force[i]
                ay += response[y, i] * force[i]
                noise += abs(response[x, i] * force[i]) + abs(response[y, i] * force[i])
            rim = friction[j] * normal[j]
            used = np.sqrt(force[x] * force[x] + force[y] * force[y])
            speed = np.sqrt(ax * ax + ay * ay)
            if used >= rim * (1.0 - 1e-12) and speed > 1e-12 * noise:
                onset[j] = True
                direction[2 * j] = ax / speed
                direction[2 * j + 1] = ay / speed
    for j in range(count):
        if onset[j]:
            grip[j] = SLIDING
