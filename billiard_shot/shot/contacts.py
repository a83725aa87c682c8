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
from billiard_shot.numerics import rounding
from billiard_shot.numerics.frames import contact_axes
from billiard_shot.numerics.vectors import cross, dot
from billiard_shot.records import Floats, Vector
from billiard_shot.shot.model import StrikeModel


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
            if apart or abs(coupling) < rounding.COUPLING * sqrt(w[i][i] * w[j][j]):
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
