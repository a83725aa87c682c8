"""
The arithmetic of a leap over many swings: collocation for x(n + 1) = x(n) + F(x(n)).

With a small and smooth F this difference equation is to swings what a differential equation is to
time (multirevolution methods: Graff and Bettis, Celestial Mechanics 11, 1975; Petzold, SIAM J.
Numer. Anal. 18, 1981). The nodes are those of Radau IIA. A sum over M swings is an integral with
the corrections of Euler and Maclaurin, which are exact for the polynomial through the nodes.

What a swing forgets (a contact that is left and met again) makes the equations stiff: all nodes
are solved for at once, by Newton's method with the Jacobian that F has at the start.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled, frugal
from billiard_shot.impact.collocation import INTEGRAL, NODES
from billiard_shot.impact.linear import solve_in_place
from billiard_shot.impact.state import STAGES

POWERS = (0, 1, 3, 5)  # of 1 / M in the corrections of a sum


def _tableau() -> tuple[NDArray[np.float64], ...]:
    """
    Return corrections of sums, the matrix to Legendre coefficients, derivatives at the end.

    The sum of p(k / M) over k from 0 to c M - 1 is M times the integral of p up to c, minus half
    the change of p, plus its derivative's change / 12 M, minus the third's / 720 M^3, and so on.
    """
    legendre = np.polynomial.legendre
    x = 2.0 * NODES - 1.0
    to_series = np.linalg.inv(legendre.legvander(x, STAGES - 1)).astype(np.float64)
    units = np.eye(STAGES)
    corrections = []
    for order, factor in zip(POWERS, (-1 / 2, 1 / 12, -1 / 720, 1 / 30240), strict=True):
        derived = [legendre.legder(unit, order) * 2.0**order for unit in units]
        change = [legendre.legval(x, d) - legendre.legval(-1.0, d) for d in derived]
        corrections.append(factor * np.array(change).T @ to_series)
    at_end = [
        [legendre.legval(1.0, legendre.legder(unit, order)) * 2.0**order for unit in units]
        for order in range(3)
    ]
    derivatives: NDArray[np.float64] = np.array(at_end) @ to_series
    return np.array(corrections), to_series, derivatives


CORRECTIONS, TO_SERIES, AT_END = _tableau()


class Span(NamedTuple):
    """A leap's unknowns: D numbers at each node, of which the first d feed back: F needs them."""

    start: NDArray[np.float64]  # (D,) x where the leap begins
    node: NDArray[np.float64]  # (STAGES, D) x at the nodes
    change: NDArray[np.float64]  # (STAGES, D) F there
    end: NDArray[np.float64]  # (D,) scratch
    weight: NDArray[np.float64]  # (STAGES, STAGES) of the sums from start to nodes
    jacobian: NDArray[np.float64]  # (d, d) of F at the start
    matrix: NDArray[np.float64]  # (STAGES d, STAGES d) scratch
    right: NDArray[np.float64]  # (STAGES d,) scratch


@compiled
def empty_span(size: int, active: int) -> Span:
    """Room for a leap."""
    return Span(
        np.empty(size),
        np.empty((STAGES, size)),
        np.empty((STAGES, size)),
        np.empty(size),
        np.empty((STAGES, STAGES)),
        np.zeros((active, active)),
        np.empty((STAGES * active, STAGES * active)),
        np.empty(STAGES * active),
    )


@frugal
def weigh(p: Span, swings: float) -> None:
    """Set the weights of the sums over a number of swings."""
    for i in range(STAGES):
        for j in range(STAGES):
            total = swings * INTEGRAL[i, j]
            for k in range(len(POWERS)):
                total += CORRECTIONS[k, i, j] * swings ** -POWERS[k]
            p.weight[i, j] = total


@frugal
def sum_to(p: Span, node: int, row: int) -> float:
    """Where the sum of F leads one number at a node."""
    total = p.start[row]
    for j in range(STAGES):
        total += p.weight[node, j] * p.change[j, row]
    return total


@frugal
def set_nodes(p: Span) -> None:
    """Set the nodes to where F leads as it is guessed; what does not feed back stays as it was."""
    for i in range(STAGES):
        for row in range(p.start.shape[0]):
            p.node[i, row] = p.start[row]
        for row in range(p.jacobian.shape[0]):
            p.node[i, row] = sum_to(p, i, row)


@frugal
def residual(p: Span, row: int) -> float:
    """How far one number is from where F leads it, at the worst of the nodes."""
    largest = 0.0
    for i in range(STAGES):
        largest = max(largest, abs(sum_to(p, i, row) - p.node[i, row]))
    return largest


@frugal
def finish(p: Span) -> None:
    """Set the start to the end."""
    for row in range(p.start.shape[0]):
        p.start[row] = sum_to(p, STAGES - 1, row)


@frugal
def move_nodes(p: Span) -> bool:
    """Move all nodes to where F leads, as far as the Jacobian foresees it: a step of Newton."""
    size = p.jacobian.shape[0]
    for i in range(STAGES):
        for a in range(size):
            p.right[i * size + a] = sum_to(p, i, a) - p.node[i, a]
            for j in range(STAGES):
                for b in range(size):
                    p.matrix[i * size + a, j * size + b] = -p.weight[i, j] * p.jacobian[a, b]
            p.matrix[i * size + a, i * size + a] += 1.0
    if not solve_in_place(p.matrix, p.right):
        return False
    for i in range(STAGES):
        for a in range(size):
            p.node[i, a] += p.right[i * size + a]
    return True


@frugal
def interpolate(p: Span, ratio: float) -> None:
    """Set F at the nodes of a span with the same start that is shorter by a ratio."""
    series = p.right
    for row in range(p.start.shape[0]):
        for k in range(STAGES):
            series[k] = 0.0
            for j in range(STAGES):
                series[k] += TO_SERIES[k, j] * p.change[j, row]
        for k in range(STAGES):
            x = 2.0 * ratio * NODES[k] - 1.0
            before, value, total = 1.0, x, series[0] + series[1] * x
            for n in range(2, STAGES):
                before, value = value, ((2 * n - 1) * x * value - (n - 1) * before) / n
                total += series[n] * value
            p.change[k, row] = total


@frugal
def extrapolate(p: Span, ratio: float) -> None:
    """Guess F at the nodes of the next span, `ratio` times as long: a parabola from its start."""
    for row in range(p.start.shape[0]):
        first, second, third = 0.0, 0.0, 0.0
        for k in range(STAGES):
            first += AT_END[0, k] * p.change[k, row]
            second += AT_END[1, k] * p.change[k, row]
            third += 0.5 * AT_END[2, k] * p.change[k, row]
        for k in range(STAGES):
            x = ratio * NODES[k]
            p.change[k, row] = first + x * (second + x * third)


@frugal
def rest(p: Span, row: int) -> float:
    """Size of the part of F that the polynomial only just resolves."""
    last, before = 0.0, 0.0
    for i in range(STAGES):
        last += TO_SERIES[STAGES - 1, i] * p.change[i, row]
        before += TO_SERIES[STAGES - 2, i] * p.change[i, row]
    return max(abs(last), 0.05 * abs(before))
