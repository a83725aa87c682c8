"""
Endless sequences that fade: summed once each round is the one before, only smaller.

With linear springs the equations of a collision are homogeneous: a state that is smaller by a
factor, slip that does not take part aside, passes the same events after the same times, all
impulses smaller by that factor and all energies by its square. So bodies that are pressed together
and lose a share of their motion with every round of impacts come to go through rounds that differ
by one ratio only, and what is left of them is a geometric series. (With forces ~ y^p compressions
shrink with another power, and the times grow; the series of the impulses is the same.)
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import frugal
from billiard_shot.impact.laws import elastic_energy
from billiard_shot.impact.state import Model, State
from billiard_shot.impact.swings import as_velocity, copy, pack, PAST, Swings, unpack

LONGEST = (PAST - 1) // 2  # swings of a round
SLOWEST = 0.999  # ratio: what fades slower may as well not be a series
SHARE = 0.1  # part of the tolerance that the sum may use up
ROUNDING = 1e-15  # of what only adds up


@frugal
def fades(m: Model, s: State, w: Swings) -> bool:
    """After a swing: whether the rest of the collision is a geometric series; if so, add it."""
    now = w.now[0]
    row = now.past % PAST
    end = w.past[row]
    pack(s, end)
    w.mark[row] = now.mark
    now.past += 1
    for swings in range(1, LONGEST + 1):
        if now.past > 2 * swings and passes_the_same(w, swings):
            last, first = w.past[(row - swings) % PAST], w.past[(row - 2 * swings) % PAST]
            before = amplitude(m, s, last, first)
            ratio = amplitude(m, s, end, last) / before if before > 0.0 else 1.0
            if ratio < SLOWEST and is_geometric(m, s, end, last, first, ratio):
                copy(s.contact, w.contact)
                copy(end, w.span.end)
                add_rest(s, w.span.end, last, first, ratio)
                unpack(m, s, w, w.span.end)
                return True
    return False


@frugal
def passes_the_same(w: Swings, swings: int) -> bool:
    """Whether the last round of swings passed the same events as the one before."""
    last = w.now[0].past - 1
    for k in range(last - swings + 1, last + 1):
        if w.mark[k % PAST] != w.mark[(k - swings) % PAST]:
            return False
    return True


@frugal
def amplitude(
    m: Model, s: State, end: NDArray[np.float64], begin: NDArray[np.float64]
) -> float:
    """How large the state still is at a round's end, as a velocity, at the contacts it pressed."""
    count = len(s.contact)
    square = 0.0
    for j in range(count):
        if end[5 * count + 3 * j] > begin[5 * count + 3 * j]:
            energy = elastic_energy(s.contact[j].stiffness, end[3 * count + j], m.exponent)
            square += end[3 * j] ** 2 + 2.0 * energy * m.response[3 * j, 3 * j]
    return float(np.sqrt(square))


@frugal
def limit(
    end: NDArray[np.float64], last: NDArray[np.float64], row: int, ratio: float
) -> float:
    """Where the rounds to come lead one number, if they differ by the ratio."""
    return float(end[row] + (end[row] - last[row]) * ratio / (1.0 - ratio))


@frugal
def is_geometric(
    m: Model, s: State, end: NDArray[np.float64], last: NDArray[np.float64],
    first: NDArray[np.float64], ratio: float,
) -> bool:  # fmt: skip
    """Whether the last two rounds differ by the ratio only, and so do the states they end with."""
    count = len(s.contact)
    allowed = SHARE * m.tolerance * (1.0 - ratio) ** 2
    shrinking = ratio ** (2.0 / (m.exponent + 1.0))  # of compressions: energies go as ratio^2
    for j in range(count):
        normal, spring, push = 3 * j, 3 * count + j, 5 * count + 3 * j
        if end[push] > last[push]:
            off = abs(end[spring] - shrinking * last[spring]) * as_velocity(m, s, spring)
            off = max(off, abs(end[normal] - ratio * last[normal]))
            if not off <= allowed:
                return False
        elif limit(end, last, normal, ratio) < 0.0:
            return False  # it will be met
        for k in range(3):
            response = m.response[normal + k, normal + k]
            for row, unit in ((normal + k, 1.0), (push + k, response)):
                off = (end[row] - last[row]) - ratio * (last[row] - first[row])
                if not abs(off) * unit <= allowed + ROUNDING * abs(end[row]) * unit:
                    return False
        slip, turned = 0.0, 0.0  # the slip now, and that of the limit along it
        for row in range(normal + 1, normal + 3):
            slip += end[row] * end[row]
            turned += end[row] * limit(end, last, row, ratio)
        if turned < -SHARE * m.tolerance * np.sqrt(slip):
            return False  # it will stop on the way
    return True


@frugal
def add_rest(
    s: State, x: NDArray[np.float64], last: NDArray[np.float64], first: NDArray[np.float64],
    ratio: float,
) -> None:  # fmt: skip
    """
    Add to x all the rounds to come.

    Of energies a part may shrink with the ratio, where what slips does not fade, the rest with its
    square: two rounds tell how much.
    """
    count = len(s.contact)
    square = ratio * ratio
    for row in range(x.shape[0]):
        change, before = x[row] - last[row], last[row] - first[row]
        if 3 * count <= row < 5 * count:  # springs
            x[row] = 0.0
        elif 8 * count <= row < 10 * count:  # energies
            part = (change - square * before) / (1.0 - ratio)
            x[row] += part * ratio / (1.0 - ratio) + (change - part) * square / (1.0 - square)
        else:
            x[row] = limit(x, last, row, ratio)
