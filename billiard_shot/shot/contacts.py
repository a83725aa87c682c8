"""
The two contacts of a strike in contact space: cue on ball at r n, and ball on table at -r z.

A row of the Jacobians says how one contact velocity (per contact: normal, first and second
tangential) depends on the velocities of the bodies and, read as a column, how a contact impulse
acts on them:
    u = C v_cue + B v + S w ,   W = C M_cue^-1 C' + B B' / m + S S' / I   (paper, equations 16-18).
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import inner
from billiard_shot.records import Floats, Vector
from billiard_shot.shot.model import StrikeModel

ROUNDING = 8 * 2.0**-52  # of a coupling, relative to the mean of what it couples


@inner
def dot(a: Vector, b: Vector) -> float:
    """Scalar product in space."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner
def cross(a: Vector, b: Vector, product: Floats) -> None:
    """Write the vector product."""
    product[0] = a[1] * b[2] - a[2] * b[1]
    product[1] = a[2] * b[0] - a[0] * b[2]
    product[2] = a[0] * b[1] - a[1] * b[0]


@inner
def perpendicular_unit(v: Vector, n: Vector, unit: Floats) -> bool:
    """Write the unit vector of the part of v that is normal to n; False if there is none."""
    for i in range(3):
        unit[i] = v[i]
    for _ in range(2):  # of a vector nearly along n, rounding leaves a part that the second takes
        along = dot(unit, n)
        for i in range(3):
            unit[i] -= along * n[i]
        length = sqrt(dot(unit, unit))
        if length <= 1e-12:
            return False
        for i in range(3):
            unit[i] /= length
    return True


@inner
def contact_axes(n: Vector, first: Vector, second: Vector, axes: Floats, at: int) -> None:
    """
    Write the axes of a contact as three rows from row `at` on: n and two tangents.

    The first tangent is in the plane of n and `first`, or `second` if that is parallel to n, or
    else anywhere.
    """
    tangent, other = axes[at + 1], axes[at + 2]
    for i in range(3):
        axes[at][i] = n[i]
    if not perpendicular_unit(first, n, tangent) and not perpendicular_unit(second, n, tangent):
        other[0], other[1], other[2] = 1.0, 0.0, 0.0
        perpendicular_unit(other, n, tangent)
    cross(n, tangent, other)


@inner
def contact_jacobians(radius: float, n: Vector, c: Vector, z: Vector, result: Floats) -> None:
    """
    Write C, B and S, (3, 6, 3), for a stroke along the unit vector c; z is the vertical.

    The tip's first tangent points along its slip. Where n, c and the vertical are in one plane, so
    are both first tangents, and nothing couples to the second ones.
    """
    on_cue, on_ball, turning = result[0], result[1], result[2]
    contact_axes(n, c, z, on_cue, 0)
    contact_axes(z, n, c, on_ball, 3)
    for i in range(3):
        cross(n, on_cue[i], turning[i])
        cross(z, on_ball[3 + i], turning[3 + i])
        for k in range(3):
            on_ball[i][k] = -on_cue[i][k]
            on_cue[3 + i][k] = 0.0
    for i in range(6):
        for k in range(3):
            turning[i][k] *= -radius


@inner
def tip_response(model: StrikeModel, c: Vector, impulse: Vector, other: Vector) -> float:
    """
    Change of the tip's velocity by an impulse on it, as far as it points along `other`.

    Along its axis c the whole cue has to move, across it only the light, flexible end.
    """
    along = dot(c, impulse)
    stiff = along / model.cue_mass * dot(c, other)
    return stiff + model.inverse_end_mass * (dot(impulse, other) - along * dot(c, other))


@inner
def delassus_operator(model: StrikeModel, c: Vector, jacobians: Floats, w: Floats) -> None:
    """Write W (6, 6) [1/kg]. Couplings that are only rounding are made exactly zero."""
    ball = model.surface
    on_cue, on_ball, turning = jacobians[0], jacobians[1], jacobians[2]
    for i in range(6):
        for j in range(6):
            w[i][j] = (
                tip_response(model, c, on_cue[i], on_cue[j])
                + dot(on_ball[j], on_ball[i]) / ball.mass
                + dot(turning[j], turning[i]) / ball.inertia
            )
    for i in range(6):
        for j in range(i):
            coupling = 0.5 * (w[i][j] + w[j][i])
            apart = not model.table and i >= 3 > j  # nothing closes the contact with the table
            if apart or abs(coupling) < ROUNDING * sqrt(w[i][i] * w[j][j]):
                coupling = 0.0
            w[i][j] = coupling
            w[j][i] = coupling


@inner
def approach_velocity(jacobians: Floats, speed: float, n: Vector, c: Vector, u: Floats) -> None:
    """Write the contact velocities u(0) (6,) [m/s] of a cue that comes to a ball at rest."""
    for i in range(6):
        u[i] = 0.0
    u[0] = speed * dot(n, c)
    u[1] = speed * dot(jacobians[0][1], c)


@inner
def weighted(weights: Vector, rows: Floats, total: Floats) -> None:
    """Write the sum of rows (6, 3) times weights (6,)."""
    for k in range(3):
        total[k] = 0.0
        for i in range(6):
            total[k] += weights[i] * rows[i][k]


def in_contact_space(
    model: StrikeModel, n: NDArray[np.float64], c: NDArray[np.float64], speed: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Jacobians (3, 6, 3), W (6, 6) and u(0) (6,) of a stroke along c at the normal n."""
    jacobians, w, u = np.zeros((3, 6, 3)), np.empty((6, 6)), np.empty(6)
    contact_jacobians(model.surface.radius, n, c, np.array([0.0, 0.0, 1.0]), jacobians)
    delassus_operator(model, c, jacobians, w)
    approach_velocity(jacobians, speed, n, c, u)
    return jacobians, w, u
