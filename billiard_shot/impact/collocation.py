"""
One step of a collision by implicit collocation: for slip that has just begun, or only creeps.

There the direction of sliding follows the forces almost at once, at a rate that grows without
bound as the slip goes to zero: explicit steps would have to be as small as the slip. Radau IIA
collocation (Hairer, Wanner, Solving ODEs II, IV.5) with the slip in polar form has no such bound,
and starts from slip exactly zero, whether it then grows as t or as t^2.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import frugal, inlined
from billiard_shot.impact.linear import solve_in_place
from billiard_shot.impact.series import integrate, lean
from billiard_shot.impact.state import INACTIVE, Model, Room, SLIDING, STAGES, State

ITERATIONS = 25
BLUR = 1e-15  # rad, turn that is only rounding
SHORTEST = 1e-14  # step below which the slip is taken not to begin at all


def _tableau(stages: int) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return Radau IIA nodes, integration matrix, and matrix from nodal values to monomials."""
    legendre = np.polynomial.legendre
    difference = np.zeros(stages + 1)
    difference[stages - 1 :] = -1.0, 1.0  # the nodes are the roots of P_s - P_(s-1) on [-1, 1]
    x = np.sort(legendre.legroots(difference).real)
    x -= legendre.legval(x, difference) / legendre.legval(x, legendre.legder(difference))
    to_series = np.linalg.inv(legendre.legvander(x, stages - 1))
    integral = np.array(
        [
            0.5 * (legendre.legval(x, antiderivative) - legendre.legval(-1.0, antiderivative))
            for antiderivative in (legendre.legint(unit) for unit in np.eye(stages))
        ]
    ).T
    shift = np.zeros((stages, stages))  # P_k(2 t - 1) in powers of t
    for k, unit in enumerate(np.eye(stages)):
        power = np.polynomial.Polynomial(legendre.leg2poly(unit))(
            np.polynomial.Polynomial([-1, 2])
        )
        shift[: k + 1, k] = power.coef
    return 0.5 * (x + 1.0), integral @ to_series, shift @ to_series


NODES, INTEGRAL, MONOMIAL = _tableau(STAGES)


class Nodes(NamedTuple):
    """The unknowns at the collocation nodes."""

    u: NDArray[np.float64]  # (3 N, STAGES)
    y: NDArray[np.float64]  # (N, STAGES)
    force: NDArray[np.float64]  # (3 N, STAGES)
    angle: NDArray[np.float64]  # (N, STAGES) by which the young contacts' slip has turned
    cosine: NDArray[np.float64]  # (N, STAGES) first component of its direction
    sine: NDArray[np.float64]  # (N, STAGES) second component
    slope: NDArray[np.float64]  # (STAGES,) scratch


@frugal
def nodal_forces(m: Model, s: State, nodes: Nodes) -> None:
    """Find the forces at the nodes: springs from y, friction from the slip's direction."""
    for j in range(len(s.contact)):
        c = s.contact[j]
        if c.phase == INACTIVE:
            continue
        n = 3 * j
        for i in range(STAGES):
            # Continued to y < 0, beyond the event that ends the step: no kink in the polynomial.
            normal = c.stiffness * np.copysign(abs(nodes.y[j, i]) ** m.exponent, nodes.y[j, i])
            nodes.force[n, i] = normal
            if c.grip == SLIDING:
                if c.young:
                    along, aside = np.cos(nodes.angle[j, i]), np.sin(nodes.angle[j, i])
                    x = c.toward_x * along - c.toward_y * aside
                    y = c.toward_y * along + c.toward_x * aside
                    nodes.cosine[j, i], nodes.sine[j, i] = x, y
                else:
                    x, y = nodes.u[n + 1, i], nodes.u[n + 2, i]
                    size = np.sqrt(x * x + y * y)
                    x, y = x / size, y / size
                nodes.force[n + 1, i] = -c.friction * normal * x
                nodes.force[n + 2, i] = -c.friction * normal * y
    lean(s, nodes.force.shape[1], nodes.force)


@frugal
def nodal_motion(s: State, nodes: Nodes, scale: float) -> float:
    """
    Contact velocities and compressions at the nodes, integrated from the nodal forces.

    Returns the largest change of a velocity since the last time.
    """
    change = 0.0
    effective = s.effective
    u, y, force, slope = nodes.u, nodes.y, nodes.force, nodes.slope
    for row in range(u.shape[0]):
        start = s.u[row, 0]
        for i in range(STAGES):
            slope[i] = 0.0
        for column in range(u.shape[0]):
            factor = scale * effective[row, column]
            if s.contact[column // 3].phase != INACTIVE and factor != 0.0:
                for i in range(STAGES):
                    slope[i] += factor * force[column, i]
        j = row // 3
        turns = s.contact[j].young != 0 and row != 3 * j
        for i in range(STAGES):
            value = start
            for k in range(STAGES):
                value += INTEGRAL[i, k] * slope[k]
            moved = abs(value - u[row, i])
            if turns:  # what changes across the slip is for the angles to say
                moved *= abs(nodes.cosine[j, i] if row == 3 * j + 1 else nodes.sine[j, i])
            change = max(change, moved)
            u[row, i] = value
    for j in range(y.shape[0]):
        if s.contact[j].phase != INACTIVE:
            start = s.y[j, 0]
            for i in range(STAGES):
                value = 0.0
                for k in range(STAGES):
                    value += INTEGRAL[i, k] * u[3 * j, k]
                y[j, i] = start - scale * s.contact[j].rate * value
    return change


@frugal
def turn(
    s: State,
    nodes: Nodes,
    scale: float,
    members: NDArray[np.int64],
    newton: NDArray[np.float64],
) -> float:
    """
    One Newton step on the angles at which the young contacts slide, at all nodes.

    The slip must point along the angle: 0 = slip_i . t_i with d_i = (cos, sin), and t_i = d_i
    turned by a right angle. Returns the largest turn, or infinity where that has no solution.
    """
    u, force, cosine, sine = nodes.u, nodes.force, nodes.cosine, nodes.sine
    effective = s.effective
    dimension = STAGES * members.shape[0]
    matrix, residual = newton[:dimension, :dimension], newton[dimension, :dimension]
    for row in range(dimension):
        j, i = members[row // STAGES], row % STAGES
        tx, ty = -sine[j, i], cosine[j, i]
        residual[row] = u[3 * j + 1, i] * tx + u[3 * j + 2, i] * ty
        for column in range(dimension):
            b, k = members[column // STAGES], column % STAGES
            x, y = 3 * b + 1, 3 * b + 2
            ax = tx * effective[3 * j + 1, x] + ty * effective[3 * j + 2, x]
            ay = tx * effective[3 * j + 1, y] + ty * effective[3 * j + 2, y]
            push = scale * INTEGRAL[i, k] * s.contact[b].friction * force[3 * b, k]
            matrix[row, column] = push * (ay * cosine[b, k] - ax * sine[b, k])
        matrix[row, row] += u[3 * j + 1, i] * ty - u[3 * j + 2, i] * tx
    if not solve_in_place(matrix, residual):
        return np.inf
    largest = 0.0
    for row in range(dimension):
        j, i = members[row // STAGES], row % STAGES
        if abs(residual[row]) > BLUR:
            largest = max(largest, abs(residual[row]))
        nodes.angle[j, i] += min(max(residual[row], -1.0), 1.0)
    return largest


@frugal
def slips_forward(nodes: Nodes, members: NDArray[np.int64]) -> bool:
    """Whether the slip is positive along its angle at all nodes of the young contacts."""
    for j in members:
        for i in range(STAGES):
            along = nodes.u[3 * j + 1, i] * nodes.cosine[j, i]
            if not along + nodes.u[3 * j + 2, i] * nodes.sine[j, i] > 0.0:
                return False
    return True


@frugal
def straighten(s: State, nodes: Nodes, j: int) -> None:
    """
    Set how far a young contact's slip turns aside to what its angle says.

    The integral of the forces says the same, but for rounding, which is large where much friction
    acts on little mass.
    """
    x, y = 3 * j + 1, 3 * j + 2
    dx, dy = s.contact[j].toward_x, s.contact[j].toward_y
    aside = nodes.slope
    for i in range(STAGES):
        size = nodes.u[x, i] * nodes.cosine[j, i] + nodes.u[y, i] * nodes.sine[j, i]
        aside[i] = size * np.sin(nodes.angle[j, i]) / NODES[i]
    for k in range(STAGES):
        along = s.u[x, k + 1] * dx + s.u[y, k + 1] * dy
        across = 0.0
        for i in range(STAGES):
            across += MONOMIAL[k, i] * aside[i]
        s.u[x, k + 1], s.u[y, k + 1] = along * dx - across * dy, along * dy + across * dx


@inlined
def solve_nodes(
    m: Model,
    s: State,
    nodes: Nodes,
    scale: float,
    tolerance: float,
    members: NDArray[np.int64],
    newton: NDArray[np.float64],
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
            nodes.y[j, i] = s.y[j, 0] - s.contact[j].rate * scale * NODES[i] * s.u[3 * j, 0]
            nodes.angle[j, i] = 0.0
    last_moved, last_turned, before = 0.0, 0.0, np.inf
    for iteration in range(ITERATIONS):
        nodal_forces(m, s, nodes)
        moved = nodal_motion(s, nodes, scale)
        turned = turn(s, nodes, scale, members, newton)
        change, last = max(moved, turned), max(last_moved, last_turned)
        if not change < np.inf or (iteration > 2 and change > 0.8 * max(last, before)):
            return False  # twice: what moved a little may make the next turn seem to go back
        contraction = max(moved / max(last_moved, moved, 1e-300), 1e-3)
        contraction = max(turned / max(last_turned, turned, 1e-300), contraction)
        if change <= max(0.3 * (1.0 / contraction - 1.0), 0.03) * tolerance:
            nodal_forces(m, s, nodes)
            nodal_motion(s, nodes, scale)
            return slips_forward(nodes, members)
        last_moved, last_turned, before = moved, turned, last
    return False


@inlined
def collocate(m: Model, s: State, room: Room, scale: float, tolerance: float) -> float:
    """
    Fill the step's polynomials on x in [0, 1] like `series.expand`, with order STAGES.

    Returns the estimated error of the velocities, infinity where the step must be shortened.
    """
    count = len(s.contact)
    young = 0
    for j in range(count):
        if s.contact[j].young:
            room.chosen[young] = j
            young += 1
    rows = room.nodes
    for row in range(rows.shape[0]):
        for i in range(STAGES):
            rows[row, i] = 0.0
    nodes = Nodes(
        rows[: 3 * count],
        rows[3 * count : 4 * count],
        rows[4 * count : 7 * count],
        rows[7 * count : 8 * count],
        rows[8 * count : 9 * count],
        rows[9 * count : 10 * count],
        rows[10 * count],
    )
    if not solve_nodes(m, s, nodes, scale, tolerance, room.chosen[:young], room.newton):
        return np.inf
    for row in range(3 * count):
        for k in range(STAGES):
            s.force[row, k] = 0.0
            for i in range(STAGES):
                s.force[row, k] += MONOMIAL[k, i] * nodes.force[row, i]
    for k in range(STAGES):
        integrate(s, scale, k)
    if young == 1:  # several may share a constraint, which their rounding must not break
        straighten(s, nodes, room.chosen[0])
    # The last coefficients, taken back to the Legendre basis, say what the next one would change:
    # P_7 and P_6 of 2 x - 1 lead with binomial(14, 7) = 3432 and binomial(12, 6) = 924.
    error = 0.0
    for row in range(3 * count):
        error = max(error, abs(s.u[row, STAGES]) * (STAGES / 3432.0))
        error = max(error, abs(s.u[row, STAGES - 1]) * (0.05 * (STAGES - 1) / 924.0))
    return error


@frugal
def implicit_step(
    m: Model, s: State, room: Room, scale: float, tolerance: float
) -> tuple[float, float]:
    """Collocate, with shorter and shorter steps until one is good; return its length and error."""
    while scale > SHORTEST:
        error = collocate(m, s, room, scale, tolerance)
        if error <= tolerance:
            return scale, error
        scale *= max(0.7 * (tolerance / error) ** (1.0 / STAGES), 0.1) if error < 1e300 else 0.25
    return 0.0, 0.0
