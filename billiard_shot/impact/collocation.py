"""
An implicit step of a collision, by collocation: for slip that has just begun, or only creeps.

There the direction of slip follows the forces almost at once, at a rate that grows without bound
as the slip goes to zero: explicit steps would have to be as small as the slip. Radau IIA
collocation (Hairer, Wanner, Solving ODEs II, IV.5) with the slip in polar form has no such bound,
and starts from slip exactly zero, whether it then grows as t or as t^2.
"""

from math import copysign, cos, inf, sin, sqrt

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import inner
from billiard_shot.impact import friction
from billiard_shot.impact.options import METHOD_OPTIONS
from billiard_shot.impact.state import (
    ContactState,
    DRAG,
    ELASTIC,
    friction_at,
    friction_is_explicit,
    GRIP,
    IMPLICIT_STAGES,
    INACTIVE,
    is_active,
    is_stiff,
    largest_coefficient,
    Model,
    shears,
    slips,
    Workspace,
)
from billiard_shot.impact.taylor import fill_stick_forces, integrate_coefficients
from billiard_shot.numerics.vectors import solve_in_place
from billiard_shot.records import Floats, OBJECTS, ROWS, Storage, Vector


def tableau(
    stages: int = IMPLICIT_STAGES,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
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


_STORAGES: tuple[Storage, ...] = (OBJECTS, ROWS)
TABLEAUS = {storage: tuple(map(storage.array, tableau())) for storage in _STORAGES}


@inner
def implicit_step(
    m: Model, contacts: list[ContactState], ws: Workspace, scale: float, tolerance: float
) -> tuple[float, float]:
    """Collocate, with a shorter step until its error is allowed; return its length and error."""
    while scale > METHOD_OPTIONS.min_implicit_step:
        error = collocate(m, contacts, ws, scale, tolerance)
        if error <= tolerance:
            return scale, error
        if error < inf:
            shorter = METHOD_OPTIONS.retry_margin * (tolerance / error) ** (1.0 / IMPLICIT_STAGES)
            scale *= max(shorter, METHOD_OPTIONS.min_retry)
        else:
            scale *= METHOD_OPTIONS.divergence_factor
    return 0.0, 0.0


@inner
def collocate(
    m: Model, contacts: list[ContactState], ws: Workspace, scale: float, tolerance: float
) -> float:
    """
    Fill the step's polynomials on x in [0, 1] like `taylor.expand`, with order IMPLICIT_STAGES.

    Returns the estimated error of the velocities, infinity if the step must be shortened.
    """
    stiff = 0
    for j in range(len(contacts)):
        if is_active(contacts[j]) and is_stiff(m, contacts[j]):
            ws.indices[stiff] = j
            stiff += 1
    if not solve_stages(m, contacts, ws, scale, tolerance, stiff):
        return inf
    for j in range(len(contacts)):
        c = contacts[j]
        if c.normal_mode == INACTIVE:
            continue
        to_coefficients(ws, c.force)
        to_coefficients(ws, c.friction_1)
        to_coefficients(ws, c.friction_2)
        if c.friction_mode == DRAG:
            set_drag_series(c, ws, scale)
    for k in range(IMPLICIT_STAGES):
        integrate_coefficients(contacts, ws, scale, k)
    if stiff == 1:  # several may share a constraint, which rounding must not violate
        align_slip_with_angle(contacts[ws.indices[0]], ws)
    # The last coefficients, transformed back to the Legendre basis, estimate the next one:
    # P_7 and P_6 of 2 x - 1 lead with binomial(14, 7) = 3432 and binomial(12, 6) = 924.
    error = 0.0
    for j in range(len(contacts)):
        last = largest_coefficient(contacts[j], IMPLICIT_STAGES) * (IMPLICIT_STAGES / 3432.0)
        before = largest_coefficient(contacts[j], IMPLICIT_STAGES - 1)
        error = max(error, last, before * (0.05 * (IMPLICIT_STAGES - 1) / 924.0))
    return error


@inner
def to_coefficients(ws: Workspace, values: Floats) -> None:
    """Convert values at the stages to coefficients."""
    at_nodes = ws.residual
    for i in range(IMPLICIT_STAGES):
        at_nodes[i] = values[i]
    for k in range(IMPLICIT_STAGES):
        values[k] = stage_dot(ws.monomial[k], at_nodes)


@inner
def stage_dot(a: Vector, b: Vector) -> float:
    """Sum of products over the stages."""
    total = 0.0
    for i in range(IMPLICIT_STAGES):
        total += a[i] * b[i]
    return total


@inner
def solve_stages(
    m: Model,
    contacts: list[ContactState],
    ws: Workspace,
    scale: float,
    tolerance: float,
    stiff: int,
) -> bool:
    """
    Iterate to the collocation solution; False if it is not found, or if the slip reverses.

    Newton's method for the stiff part, the direction of slow slip; plain substitution for the
    rest, which changes little within a step.
    """
    for j in range(len(contacts)):
        c = contacts[j]
        for i in range(IMPLICIT_STAGES):
            c.node_velocity[i] = c.velocity[0]
            c.node_slip_1[i], c.node_slip_2[i] = c.slip_1[0], c.slip_2[0]
            sinking = c.compression_rate * scale * ws.stages[i] * c.velocity[0]
            c.node_compression[i] = c.compression[0] - sinking
            c.angle[i], c.cosine[i], c.sine[i] = 0.0, 0.0, 0.0
            if c.friction_mode == DRAG:
                c.cosine[i], c.sine[i] = c.slip_dir_1, c.slip_dir_2
    last_moved, last_turned, before = 0.0, 0.0, inf
    for iteration in range(METHOD_OPTIONS.max_iterations):
        set_stage_forces(m, contacts, ws, scale)
        moved = set_stage_motion(m, contacts, ws, scale)
        turned = newton_on_slip_angles(contacts, ws, scale, stiff)
        change, last = max(moved, turned), max(last_moved, last_turned)
        if not change < inf or (
            iteration > 2 and change > METHOD_OPTIONS.stalling * max(last, before)
        ):
            return False  # relative to two: after one small change the next may seem to grow
        contraction = max(moved / max(last_moved, moved, 1e-300), METHOD_OPTIONS.min_contraction)
        contraction = max(turned / max(last_turned, turned, 1e-300), contraction)
        share = METHOD_OPTIONS.iteration_share * (1.0 / contraction - 1.0)
        if change <= max(share, METHOD_OPTIONS.min_iteration_share) * tolerance:
            set_stage_forces(m, contacts, ws, scale)
            set_stage_motion(m, contacts, ws, scale)
            return slips_forward(contacts, ws, stiff)
        last_moved, last_turned, before = moved, turned, last
    return False


@inner
def set_stage_forces(m: Model, contacts: list[ContactState], ws: Workspace, scale: float) -> None:
    """Find the forces at the stages: springs from y, friction from the direction of slip."""
    for j in range(len(contacts)):
        c = contacts[j]
        if c.normal_mode == INACTIVE:
            continue
        if shears(c):
            set_shear_stages(m, c, ws, scale)
            continue
        stiff, slipping = is_stiff(m, c), slips(c)
        for i in range(IMPLICIT_STAGES):
            # Continued to y < 0, beyond the event that ends the step, to avoid a kink.
            y = c.node_compression[i]
            c.force[i] = c.stiffness * copysign(abs(y) ** c.exponent, y)
            c.friction_1[i], c.friction_2[i] = 0.0, 0.0
            if c.friction_mode == ELASTIC:
                shift_1 = c.shift_1[0] + scale * stage_dot(ws.integral[i], c.node_slip_1)
                shift_2 = c.shift_2[0] + scale * stage_dot(ws.integral[i], c.node_slip_2)
                c.friction_1[i] = -(c.spring * shift_1 + c.damping * c.node_slip_1[i])
                c.friction_2[i] = -(c.spring * shift_2 + c.damping * c.node_slip_2[i])
            elif slipping:
                slip_1, slip_2 = c.node_slip_1[i], c.node_slip_2[i]
                if stiff:
                    along, aside = cos(c.angle[i]), sin(c.angle[i])
                    d_1 = c.slip_dir_1 * along - c.slip_dir_2 * aside
                    d_2 = c.slip_dir_2 * along + c.slip_dir_1 * aside
                    c.cosine[i], c.sine[i] = d_1, d_2
                    size = max(slip_1 * d_1 + slip_2 * d_2, 0.0)
                else:
                    size = max(sqrt(slip_1 * slip_1 + slip_2 * slip_2), 1e-300)
                    d_1, d_2 = slip_1 / size, slip_2 / size
                rub = friction_at(c, size) * c.force[i]
                c.friction_1[i], c.friction_2[i] = -rub * d_1, -rub * d_2
    fill_stick_forces(contacts, ws, IMPLICIT_STAGES)


@inner
def set_shear_stages(m: Model, c: ContactState, ws: Workspace, scale: float) -> None:
    """
    Find the forces at the stages of a contact that shears (friction.py).

    If it drags, `dir` is the rate of its shear until the stages are solved.
    """
    width, stiffness = friction.cone_width(c), friction.drag_stiffness(c)
    turning = friction.turning_of(m.planar, c) if c.friction_mode == DRAG else friction.STRAIGHT
    for i in range(IMPLICIT_STAGES):
        d_1, d_2, slip_1, slip_2 = c.cosine[i], c.sine[i], c.node_slip_1[i], c.node_slip_2[i]
        c.sliding[i] = slip_1 * d_1 + slip_2 * d_2
        c.sliding[i] += width * c.compression_rate * c.node_velocity[i]
        c.dir_1[i], c.dir_2[i] = slip_1, slip_2
        if c.friction_mode == DRAG:
            c.dir_1[i], c.dir_2[i] = slip_1 - c.sliding[i] * d_1, slip_2 - c.sliding[i] * d_2
    for i in range(IMPLICIT_STAGES):
        y = c.node_compression[i]
        u_1 = c.shift_1[0] + scale * stage_dot(ws.integral[i], c.dir_1)
        u_2 = c.shift_2[0] + scale * stage_dot(ws.integral[i], c.dir_2)
        if c.friction_mode == GRIP:
            c.force[i], c.friction_1[i], c.friction_2[i] = friction.shear_force(c, y, u_1, u_2)
            continue
        if turning == friction.FOLLOWS:
            u_1, u_2 = c.node_slip_1[i], c.node_slip_2[i]
        if turning != friction.STRAIGHT:
            size = max(sqrt(u_1 * u_1 + u_2 * u_2), 1e-300)
            c.cosine[i], c.sine[i] = u_1 / size, u_2 / size
        c.force[i] = stiffness * copysign(abs(y) ** c.exponent, y)
        c.size[i] = c.node_slip_1[i] * c.cosine[i] + c.node_slip_2[i] * c.sine[i]
        c.friction_1[i] = -c.friction * c.force[i] * c.cosine[i]
        c.friction_2[i] = -c.friction * c.force[i] * c.sine[i]


@inner
def set_drag_series(c: ContactState, ws: Workspace, scale: float) -> None:
    """Convert what a contact that drags did at the stages to coefficients."""
    to_coefficients(ws, c.size)
    to_coefficients(ws, c.sliding)
    to_coefficients(ws, c.dir_1)
    to_coefficients(ws, c.dir_2)
    for k in range(IMPLICIT_STAGES):
        factor = scale / (k + 1)
        c.shift_1[k + 1], c.shift_2[k + 1] = factor * c.dir_1[k], factor * c.dir_2[k]


@inner
def set_stage_motion(m: Model, contacts: list[ContactState], ws: Workspace, scale: float) -> float:
    """
    Integrate velocities and compressions at the stages from the forces there.

    Returns the largest change of a velocity since the last time. For a stiff contact only the
    change along its slip counts: the angles determine the change across.
    """
    change = 0.0
    slope = ws.residual
    for j in range(len(contacts)):
        c = contacts[j]
        stiff = is_active(c) and is_stiff(m, c)
        add_slopes(contacts, ws.reduced[3 * j], scale, slope)
        for i in range(IMPLICIT_STAGES):
            value = c.velocity[0] + stage_dot(ws.integral[i], slope)
            change = max(change, abs(value - c.node_velocity[i]))
            c.node_velocity[i] = value
        add_slopes(contacts, ws.reduced[3 * j + 1], scale, slope)
        for i in range(IMPLICIT_STAGES):
            value = c.slip_1[0] + stage_dot(ws.integral[i], slope)
            share = abs(c.cosine[i]) if stiff else 1.0
            change = max(change, share * abs(value - c.node_slip_1[i]))
            c.node_slip_1[i] = value
        add_slopes(contacts, ws.reduced[3 * j + 2], scale, slope)
        for i in range(IMPLICIT_STAGES):
            value = c.slip_2[0] + stage_dot(ws.integral[i], slope)
            share = abs(c.sine[i]) if stiff else 1.0
            change = max(change, share * abs(value - c.node_slip_2[i]))
            c.node_slip_2[i] = value
    for j in range(len(contacts)):
        c = contacts[j]
        if is_active(c):
            for i in range(IMPLICIT_STAGES):
                sinking = stage_dot(ws.integral[i], c.node_velocity)
                c.node_compression[i] = c.compression[0] - scale * c.compression_rate * sinking
    return change


@inner
def add_slopes(
    contacts: list[ContactState], response: Vector, scale: float, slope: Floats
) -> None:
    """Write the accelerations of one contact velocity at the stages, times the scale."""
    for i in range(IMPLICIT_STAGES):
        slope[i] = 0.0
    for j in range(len(contacts)):
        c = contacts[j]
        if is_active(c):
            add_times(scale * response[3 * j], c.force, slope)
            if friction_is_explicit(c):
                add_times(scale * response[3 * j + 1], c.friction_1, slope)
                add_times(scale * response[3 * j + 2], c.friction_2, slope)


@inner
def add_times(factor: float, values: Vector, total: Floats) -> None:
    """Add values at the stages, times a factor."""
    if factor != 0.0:
        for i in range(IMPLICIT_STAGES):
            total[i] += factor * values[i]


@inner
def newton_on_slip_angles(
    contacts: list[ContactState], ws: Workspace, scale: float, stiff: int
) -> float:
    """
    Make one Newton step on the slip angles of the stiff contacts, at all stages.

    The slip must point along the angle: 0 = slip_i . t_i with d_i = (cos, sin), and t_i = d_i
    turned by a right angle. Returns the largest turn, or infinity if the matrix is singular.
    """
    matrix, residual = ws.newton, ws.residual
    size = IMPLICIT_STAGES * stiff
    for row in range(size):
        j, i = ws.indices[row // IMPLICIT_STAGES], row % IMPLICIT_STAGES
        c = contacts[j]
        t_1, t_2 = -c.sine[i], c.cosine[i]
        residual[row] = c.node_slip_1[i] * t_1 + c.node_slip_2[i] * t_2
        row_1, row_2 = ws.reduced[3 * j + 1], ws.reduced[3 * j + 2]
        for column in range(size):
            b, k = ws.indices[column // IMPLICIT_STAGES], column % IMPLICIT_STAGES
            d, x, y = contacts[b], 3 * b + 1, 3 * b + 2
            along_1 = t_1 * row_1[x] + t_2 * row_2[x]
            along_2 = t_1 * row_1[y] + t_2 * row_2[y]
            push = scale * ws.integral[i][k] * d.friction * d.force[k]
            matrix[row][column] = push * (along_2 * d.cosine[k] - along_1 * d.sine[k])
        matrix[row][row] += c.node_slip_1[i] * t_2 - c.node_slip_2[i] * t_1
    if not solve_in_place(matrix, residual, size):
        return inf
    largest = 0.0
    for row in range(size):
        if abs(residual[row]) > METHOD_OPTIONS.min_turn:
            largest = max(largest, abs(residual[row]))
        c = contacts[ws.indices[row // IMPLICIT_STAGES]]
        c.angle[row % IMPLICIT_STAGES] += min(max(residual[row], -1.0), 1.0)
    return largest


@inner
def slips_forward(contacts: list[ContactState], ws: Workspace, stiff: int) -> bool:
    """Whether the slip is positive along its angle at all stages of the stiff contacts."""
    for n in range(stiff):
        c = contacts[ws.indices[n]]
        for i in range(IMPLICIT_STAGES):
            if not c.node_slip_1[i] * c.cosine[i] + c.node_slip_2[i] * c.sine[i] > 0.0:
                return False
    return True


@inner
def align_slip_with_angle(c: ContactState, ws: Workspace) -> None:
    """
    Set the transverse slip of a stiff contact from its angle.

    The integral of the forces gives the same except for rounding, which is large if strong
    friction acts on a small mass.
    """
    d_1, d_2 = c.slip_dir_1, c.slip_dir_2
    aside = ws.residual
    for i in range(IMPLICIT_STAGES):
        size = c.node_slip_1[i] * c.cosine[i] + c.node_slip_2[i] * c.sine[i]
        aside[i] = size * sin(c.angle[i]) / ws.stages[i]
    for k in range(IMPLICIT_STAGES):
        along = c.slip_1[k + 1] * d_1 + c.slip_2[k + 1] * d_2
        across = stage_dot(ws.monomial[k], aside)
        c.slip_1[k + 1] = along * d_1 - across * d_2
        c.slip_2[k + 1] = along * d_2 + across * d_1
