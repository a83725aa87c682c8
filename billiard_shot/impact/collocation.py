"""
One step of a collision by implicit collocation: for slip that has just begun, or only creeps.

There the direction of sliding follows the forces almost at once, at a rate that grows without bound as
the slip goes to zero: explicit steps would have to be as small as the slip. Radau IIA collocation
(Hairer, Wanner, Solving ODEs II, IV.5) with the slip in polar form has no such bound, and starts from
slip exactly zero, whether it then grows as t or as t^2.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.impact.friction import SLIDING
from billiard_shot.impact.linear import solve_in_place
from billiard_shot.impact.series import accelerate, lean

STAGES = 8
ITERATIONS = 25


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


@compiled
def nodal_forces(
    gain: NDArray[np.float64],
    friction: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    exponent: float,
    active: NDArray[np.bool_],
    grip: NDArray[np.int64],
    young: NDArray[np.bool_],
    angle: NDArray[np.float64],
    u: NDArray[np.float64],
    y: NDArray[np.float64],
    force: NDArray[np.float64],
) -> None:
    """Forces at the nodes: springs from y, friction from the slip's direction."""
    for j in range(friction.shape[0]):
        if not active[j]:
            continue
        n = 3 * j
        for i in range(STAGES):
            force[n, i] = stiffness[j] * max(y[j, i], 0.0) ** exponent
            if grip[j] == SLIDING:
                if young[j]:
                    dx, dy = np.cos(angle[j, i]), np.sin(angle[j, i])
                else:
                    size = np.sqrt(u[n + 1, i] ** 2 + u[n + 2, i] ** 2)
                    dx, dy = u[n + 1, i] / size, u[n + 2, i] / size
                force[n + 1, i] = -friction[j] * force[n, i] * dx
                force[n + 2, i] = -friction[j] * force[n, i] * dy
    lean(gain, friction, active, grip, STAGES, force)


@compiled
def nodal_motion(
    effective: NDArray[np.float64],
    rate: NDArray[np.float64],
    active: NDArray[np.bool_],
    scale: float,
    start_u: NDArray[np.float64],
    start_y: NDArray[np.float64],
    force: NDArray[np.float64],
    u: NDArray[np.float64],
    y: NDArray[np.float64],
) -> None:
    """Contact velocities and compressions at the nodes, integrated from the nodal forces."""
    acceleration = np.zeros(STAGES)
    for row in range(u.shape[0]):
        for i in range(STAGES):
            total = 0.0
            for column in range(u.shape[0]):
                if active[column // 3]:
                    total += effective[row, column] * force[column, i]
            acceleration[i] = total
        for i in range(STAGES):
            total = 0.0
            for m in range(STAGES):
                total += INTEGRAL[i, m] * acceleration[m]
            u[row, i] = start_u[row] + scale * total
    for j in range(start_y.shape[0]):
        if active[j]:
            for i in range(STAGES):
                total = 0.0
                for m in range(STAGES):
                    total += INTEGRAL[i, m] * u[3 * j, m]
                y[j, i] = start_y[j] - rate[j] * scale * total


@compiled
def polar_newton(
    effective: NDArray[np.float64],
    friction: NDArray[np.float64],
    scale: float,
    members: NDArray[np.int64],
    force: NDArray[np.float64],
    u: NDArray[np.float64],
    angle: NDArray[np.float64],
    size: NDArray[np.float64],
) -> float:
    """
    One Newton step on slip(t_i) = size_i (cos angle_i, sin angle_i) at all nodes of the young contacts.

    Returns the largest change of an angle, or infinity where the step fails.
    """
    count = members.shape[0]
    dimension = 2 * STAGES * count
    matrix = np.zeros((dimension, dimension))
    residual = np.empty(dimension)
    for a in range(count):
        j = members[a]
        for i in range(STAGES):
            row = 2 * (a * STAGES + i)
            c, s = np.cos(angle[j, i]), np.sin(angle[j, i])
            residual[row] = size[j, i] * c - u[3 * j + 1, i]
            residual[row + 1] = size[j, i] * s - u[3 * j + 2, i]
            matrix[row, row] -= c
            matrix[row + 1, row] -= s
            matrix[row, row + 1] += size[j, i] * s
            matrix[row + 1, row + 1] -= size[j, i] * c
            for b in range(count):
                k = members[b]
                for m in range(STAGES):
                    column = 2 * (b * STAGES + m) + 1
                    push = -scale * INTEGRAL[i, m] * friction[k] * force[3 * k, m]
                    dx, dy = -np.sin(angle[k, m]) * push, np.cos(angle[k, m]) * push
                    for t in range(2):
                        matrix[row + t, column] += (
                            effective[3 * j + 1 + t, 3 * k + 1] * dx
                            + effective[3 * j + 1 + t, 3 * k + 2] * dy
                        )
    if not solve_in_place(matrix, residual, dimension):
        return np.inf
    largest = 0.0
    for a in range(count):
        j = members[a]
        for i in range(STAGES):
            row = 2 * (a * STAGES + i)
            size[j, i] += residual[row]
            turn = residual[row + 1]
            largest = max(largest, abs(turn))
            angle[j, i] += min(max(turn, -1.0), 1.0)
    return largest


@compiled
def collocate(
    effective: NDArray[np.float64],
    gain: NDArray[np.float64],
    friction: NDArray[np.float64],
    stiffness: NDArray[np.float64],
    exponent: float,
    rate: NDArray[np.float64],
    active: NDArray[np.bool_],
    grip: NDArray[np.int64],
    young: NDArray[np.bool_],
    direction: NDArray[np.float64],
    scale: float,
    tolerance: float,
    u: NDArray[np.float64],
    y: NDArray[np.float64],
    force: NDArray[np.float64],
) -> float:
    """
    Fill the step's polynomials on x = time / scale in [0, 1], from column 0 of u and y.

    force[:, :STAGES], u[:, :STAGES + 1] and y[:, :STAGES + 1] hold power series like those of
    `series.expand`. Returns the estimated error of the velocities, infinity where the equations could
    not be solved or the slip does not stay positive: then the step must be shortened.
    """
    count = friction.shape[0]
    members = np.empty(count, np.int64)
    young_count = 0
    for j in range(count):
        if active[j] and grip[j] == SLIDING and young[j]:
            members[young_count] = j
            young_count += 1
    members = members[:young_count]
    start_u, start_y = u[:, 0].copy(), y[:, 0].copy()
    nodes_u, nodes_y = np.empty((3 * count, STAGES)), np.zeros((count, STAGES))
    nodes_force = np.zeros((3 * count, STAGES))
    angle, size = np.zeros((count, STAGES)), np.zeros((count, STAGES))
    for i in range(STAGES):
        nodes_u[:, i] = start_u
        for j in range(count):
            nodes_y[j, i] = start_y[j] - rate[j] * scale * NODES[i] * start_u[3 * j]
            angle[j, i] = np.arctan2(direction[2 * j + 1], direction[2 * j])
    previous = 1.0
    for iteration in range(ITERATIONS):
        nodal_forces(
            gain, friction, stiffness, exponent, active, grip, young, angle, nodes_u, nodes_y, nodes_force
        )
        nodal_motion(effective, rate, active, scale, start_u, start_y, nodes_force, nodes_u, nodes_y)
        if iteration == 0:
            for j in members:
                for i in range(STAGES):
                    c, s = np.cos(angle[j, i]), np.sin(angle[j, i])
                    size[j, i] = max(nodes_u[3 * j + 1, i] * c + nodes_u[3 * j + 2, i] * s, 0.0)
            continue
        change = polar_newton(effective, friction, scale, members, nodes_force, nodes_u, angle, size)
        if not change < 10.0:
            return np.inf
        if change <= 1e-13 or (change < 1e-9 and change >= 0.3 * previous):
            break
        previous = change
        if iteration == ITERATIONS - 1:
            return np.inf
    for j in members:
        for i in range(STAGES):
            if not size[j, i] > 0.0:
                return np.inf
    nodal_forces(
        gain, friction, stiffness, exponent, active, grip, young, angle, nodes_u, nodes_y, nodes_force
    )
    for row in range(3 * count):
        if active[row // 3]:
            for k in range(STAGES):
                total = 0.0
                for i in range(STAGES):
                    total += MONOMIAL[k, i] * nodes_force[row, i]
                force[row, k] = total
    for k in range(STAGES):
        accelerate(effective, friction, active, grip, scale, k, u, force)
        for j in range(count):
            if active[j]:
                y[j, k + 1] = -rate[j] * scale * u[3 * j, k] / (k + 1)
    # The last coefficients, taken back to the Legendre basis, say what the next one would change:
    # P_7 and P_6 of 2 x - 1 lead with binomial(14, 7) = 3432 and binomial(12, 6) = 924.
    error = 0.0
    for row in range(3 * count):
        error = max(error, abs(u[row, STAGES]) * (STAGES / 3432.0))
        error = max(error, abs(u[row, STAGES - 1]) * (0.05 * (STAGES - 1) / 924.0))
    return error
