"""
One step of a collision by implicit collocation: for slip that has just begun, or only creeps.

There the direction of sliding follows the forces almost at once, at a rate that grows without bound as
the slip goes to zero: explicit steps would have to be as small as the slip. Radau IIA collocation
(Hairer, Wanner, Solving ODEs II, IV.5) with the slip in polar form has no such bound, and starts from
slip exactly zero, whether it then grows as t or as t^2.
"""
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.impact.linear import solve_in_place
from billiard_shot.impact.series import integrate, lean
from billiard_shot.impact.state import INACTIVE, SLIDING, Model, State, slip_speed

STAGES = 8
ITERATIONS = 25
SHORTEST = 1e-14  # step below which the slip is taken not to begin at all


def _tableau(stages: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return Radau IIA nodes, integration matrix, and the matrix from nodal values to monomials."""
    legendre = np.polynomial.legendre
    difference = np.zeros(stages + 1)
    difference[stages - 1 :] = -1.0, 1.0  # the nodes are the roots of P_s - P_(s-1) on [-1, 1]
    x = np.sort(legendre.legroots(difference).real)
    x -= legendre.legval(x, difference) / legendre.legval(x, legendre.legder(difference))
    to_series = np.linalg.inv(legendre.legvander(x, stages - 1))
    integral = np.array([
        0.5 * (legendre.legval(x, antiderivative) - legendre.legval(-1.0, antiderivative))
        for antiderivative in (legendre.legint(unit) for unit in np.eye(stages))
    ]).T
    shift = np.zeros((stages, stages))  # P_k(2 t - 1) in powers of t
    for k, unit in enumerate(np.eye(stages)):
        power = np.polynomial.Polynomial(legendre.leg2poly(unit))(np.polynomial.Polynomial([-1, 2]))
        shift[: k + 1, k] = power.coef
    return 0.5 * (x + 1.0), integral @ to_series, shift @ to_series


NODES, INTEGRAL, MONOMIAL = _tableau(STAGES)


class Nodes(NamedTuple):
    """The unknowns at the collocation nodes."""

    u: NDArray[np.float64]  # (3 N, STAGES)
    y: NDArray[np.float64]  # (N, STAGES)
    force: NDArray[np.float64]  # (3 N, STAGES)
    angle: NDArray[np.float64]  # (N, STAGES) of the young contacts' slip
    size: NDArray[np.float64]  # (N, STAGES) of the young contacts' slip
    slope: NDArray[np.float64]  # (STAGES,) scratch


@compiled
def nodal_forces(m: Model, s: State, nodes: Nodes) -> None:
    """Forces at the nodes: springs from y, friction from the slip's direction."""
    for j in range(m.friction.shape[0]):
        if s.phase[j] == INACTIVE:
            continue
        n = 3 * j
        for i in range(STAGES):
            normal = m.stiffness[j] * max(nodes.y[j, i], 0.0) ** m.exponent
            nodes.force[n, i] = normal
            if s.grip[j] == SLIDING:
                if s.young[j]:
                    x, y = np.cos(nodes.angle[j, i]), np.sin(nodes.angle[j, i])
                else:
                    x, y = nodes.u[n + 1, i], nodes.u[n + 2, i]
                    size = np.sqrt(x * x + y * y)
                    x, y = x / size, y / size
                nodes.force[n + 1, i] = -m.friction[j] * normal * x
                nodes.force[n + 2, i] = -m.friction[j] * normal * y
    lean(s, nodes.force.shape[1], nodes.force)


@compiled
def nodal_motion(s: State, nodes: Nodes, scale: float) -> float:
    """
    Contact velocities and compressions at the nodes, integrated from the nodal forces.

    Returns the largest change of a velocity since the last time.
    """
    change = 0.0
    rows = s.u.shape[0]
    for row in range(rows):
        for i in range(STAGES):
            nodes.slope[i] = 0.0
            for column in range(rows):
                if s.phase[column // 3] != INACTIVE:
                    nodes.slope[i] += s.effective[row, column] * nodes.force[column, i]
        for i in range(STAGES):
            value = s.u[row, 0]
            for k in range(STAGES):
                value += scale * INTEGRAL[i, k] * nodes.slope[k]
            change = max(change, abs(value - nodes.u[row, i]))
            nodes.u[row, i] = value
    for j in range(s.y.shape[0]):
        if s.phase[j] != INACTIVE:
            for i in range(STAGES):
                value = s.y[j, 0]
                for k in range(STAGES):
                    value -= scale * s.rate[j] * INTEGRAL[i, k] * nodes.u[3 * j, k]
                nodes.y[j, i] = value
    return change


@compiled
def polar_newton(
    m: Model, s: State, nodes: Nodes, scale: float, members: NDArray[np.int64]
) -> float:
    """
    One Newton step on slip(t_i) = size_i (cos angle_i, sin angle_i) at all nodes of the young contacts.

    Returns the largest change of an angle, or infinity where the step fails.
    """
    count = members.shape[0]
    dimension = 2 * STAGES * count
    matrix = np.zeros((dimension, dimension))
    residual = np.zeros(dimension)
    for row in range(dimension):
        j, i, t = members[row // (2 * STAGES)], (row // 2) % STAGES, row % 2
        c, d = np.cos(nodes.angle[j, i]), np.sin(nodes.angle[j, i])
        along, across = (c, -d) if t == 0 else (d, c)
        residual[row] = nodes.size[j, i] * along - nodes.u[3 * j + 1 + t, i]
        matrix[row, 2 * (row // 2)] -= along
        matrix[row, 2 * (row // 2) + 1] -= nodes.size[j, i] * across
        for column in range(1, dimension, 2):
            b, k = members[column // (2 * STAGES)], (column // 2) % STAGES
            push = -scale * INTEGRAL[i, k] * m.friction[b] * nodes.force[3 * b, k]
            x, y = -np.sin(nodes.angle[b, k]) * push, np.cos(nodes.angle[b, k]) * push
            matrix[row, column] += s.effective[3 * j + 1 + t, 3 * b + 1] * x
            matrix[row, column] += s.effective[3 * j + 1 + t, 3 * b + 2] * y
    if not solve_in_place(matrix, residual):
        return np.inf
    largest = 0.0
    for row in range(0, dimension, 2):
        j, i = members[row // (2 * STAGES)], (row // 2) % STAGES
        turn = residual[row + 1]
        largest = max(largest, abs(turn))
        nodes.size[j, i] += residual[row]
        nodes.angle[j, i] += min(max(turn, -1.0), 1.0)
    return largest


@compiled
def solve_nodes(
    m: Model, s: State, nodes: Nodes, scale: float, tolerance: float, members: NDArray[np.int64]
) -> bool:
    """
    Iterate to the collocation solution; False where it is not found or the slip reverses.

    Newton's method for the stiff part, the direction of the young slip; plain substitution for
    the rest, which changes little within a step.
    """
    for i in range(STAGES):
        for row in range(s.u.shape[0]):
            nodes.u[row, i] = s.u[row, 0]
        for j in range(s.y.shape[0]):
            nodes.y[j, i] = s.y[j, 0] - s.rate[j] * scale * NODES[i] * s.u[3 * j, 0]
            nodes.angle[j, i] = np.arctan2(s.direction[j, 1], s.direction[j, 0])
    nodal_forces(m, s, nodes)
    nodal_motion(s, nodes, scale)
    for j in members:
        for i in range(STAGES):
            c, d = np.cos(nodes.angle[j, i]), np.sin(nodes.angle[j, i])
            nodes.size[j, i] = max(nodes.u[3 * j + 1, i] * c + nodes.u[3 * j + 2, i] * d, 0.0)
    previous = np.inf
    for _ in range(ITERATIONS):
        nodal_forces(m, s, nodes)
        moved = nodal_motion(s, nodes, scale)
        change = max(moved, polar_newton(m, s, nodes, scale, members))
        if not change < 10.0:
            return False
        if change <= 1e-15 or (change < 0.01 * tolerance and change >= 0.3 * previous):
            for j in members:
                for i in range(STAGES):
                    if not nodes.size[j, i] > 0.0:
                        return False
            nodal_forces(m, s, nodes)
            return True
        previous = change
    return False


@compiled
def collocate(m: Model, s: State, scale: float, tolerance: float) -> float:
    """
    Fill the step's polynomials on x in [0, 1] like `series.expand`, with order STAGES.

    Returns the estimated error of the velocities, infinity where the step must be shortened.
    """
    count = m.friction.shape[0]
    nodes = Nodes(
        np.zeros((3 * count, STAGES)), np.zeros((count, STAGES)), np.zeros((3 * count, STAGES)),
        np.zeros((count, STAGES)), np.zeros((count, STAGES)), np.zeros(STAGES),
    )
    if not solve_nodes(m, s, nodes, scale, tolerance, np.flatnonzero(s.young)):
        return np.inf
    for row in range(3 * count):
        for k in range(STAGES):
            s.force[row, k] = 0.0
            for i in range(STAGES):
                s.force[row, k] += MONOMIAL[k, i] * nodes.force[row, i]
    for k in range(STAGES):
        integrate(m, s, scale, k)
    # The last coefficients, taken back to the Legendre basis, say what the next one would change:
    # P_7 and P_6 of 2 x - 1 lead with binomial(14, 7) = 3432 and binomial(12, 6) = 924.
    error = 0.0
    for row in range(3 * count):
        error = max(error, abs(s.u[row, STAGES]) * (STAGES / 3432.0))
        error = max(error, abs(s.u[row, STAGES - 1]) * (0.05 * (STAGES - 1) / 924.0))
    return error


@compiled
def implicit_step(m: Model, s: State, scale: float, tolerance: float) -> tuple[float, float]:
    """Collocate, with shorter and shorter steps until one is good; return its length and error."""
    for j in range(m.friction.shape[0]):
        if s.young[j] and not s.onset[j]:
            size = slip_speed(s, j)
            s.direction[j, 0] = s.u[3 * j + 1, 0] / size
            s.direction[j, 1] = s.u[3 * j + 2, 0] / size
    while scale > SHORTEST:
        error = collocate(m, s, scale, tolerance)
        if error <= tolerance:
            return scale, error
        scale *= max(0.7 * (tolerance / error) ** (1.0 / STAGES), 0.1) if error < 1e300 else 0.25
    return 0.0, 0.0
