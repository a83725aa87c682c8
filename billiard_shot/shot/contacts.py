"""
The two contacts of a strike in contact space: cue on ball at r n, and ball on table at -r z.

A row of `levers` says how one contact velocity (per contact: normal, first and second tangential)
depends on the velocities of the bodies, and, read as a column, how a contact impulse acts on them:
    u = C v_cue + B v + S w ,   W = C M_cue^-1 C' + B B' / m + S S' / I   (paper, equations 16-18).
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled, frugal
from billiard_shot.shot.model import Model

ROUNDING = 8 * 2.0**-52


@frugal
def dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Scalar product in space."""
    product: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


@frugal
def cross(a: NDArray[np.float64], b: NDArray[np.float64], product: NDArray[np.float64]) -> None:
    """Write the vector product."""
    product[0] = a[1] * b[2] - a[2] * b[1]
    product[1] = a[2] * b[0] - a[0] * b[2]
    product[2] = a[0] * b[1] - a[1] * b[0]


@frugal
def across(v: NDArray[np.float64], n: NDArray[np.float64], unit: NDArray[np.float64]) -> bool:
    """Write the unit vector of the part of a vector v that is normal to n; not if it is none."""
    for i in range(3):
        unit[i] = v[i]
    for _ in range(2):  # of a vector nearly along n, rounding leaves a part that the second takes
        along = dot(unit, n)
        for i in range(3):
            unit[i] -= along * n[i]
        length = np.sqrt(dot(unit, unit))
        if length <= 1e-12:
            return False
        for i in range(3):
            unit[i] /= length
    return True


@frugal
def frame(n: NDArray[np.float64], first: NDArray[np.float64], second: NDArray[np.float64],
          axes: NDArray[np.float64]) -> None:
    """
    Write the axes of a contact as rows: n and two tangential ones.

    The first of those is in the plane of n and `first`, or `second` where that is parallel to n,
    or else anywhere.
    """
    for i in range(3):
        axes[0, i] = n[i]
    if not across(first, n, axes[1]) and not across(second, n, axes[1]):
        axes[2, 0], axes[2, 1], axes[2, 2] = 1.0, 0.0, 0.0
        across(axes[2], n, axes[1])
    cross(n, axes[1], axes[2])


@compiled
def levers(radius: float, n: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    """
    C, B and S, (6, 3) each, for a stroke along the unit vector c.

    The tip's first tangent points along its slip. Where n, c and the vertical are in one plane, so
    are both first tangents, and nothing couples to the second ones.
    """
    result = np.zeros((3, 6, 3))
    z = np.zeros(3)
    z[2] = 1.0
    frame(n, c, z, result[0, :3])
    frame(z, n, c, result[1, 3:])
    for i in range(3):
        cross(n, result[0, i], result[2, i])
        cross(z, result[1, 3 + i], result[2, 3 + i])
        for k in range(3):
            result[1, i, k] = -result[0, i, k]
    for i in range(6):
        for k in range(3):
            result[2, i, k] *= -radius
    return result


@frugal
def yielding(model: Model, c: NDArray[np.float64], impulse: NDArray[np.float64],
             other: NDArray[np.float64]) -> float:
    """
    Change of the tip's velocity by an impulse on it, as far as it points along `other`.

    Along its axis c the whole cue has to move, across it only the light, flexible end.
    """
    along = dot(c, impulse)
    stiff = along / model.cue_mass * dot(c, other)
    return stiff + model.softness * (dot(impulse, other) - along * dot(c, other))


@compiled
def response_of(model: Model, c: NDArray[np.float64], lever: NDArray[np.float64],
                ) -> NDArray[np.float64]:
    """W (6, 6) [1/kg]. Couplings that are only rounding are made exactly zero."""
    ball = model.surface
    w = np.empty((6, 6))
    for i in range(6):
        for j in range(6):
            w[i, j] = (yielding(model, c, lever[0, i], lever[0, j])
                       + dot(lever[1, j], lever[1, i]) / ball.mass
                       + dot(lever[2, j], lever[2, i]) / ball.inertia)
    for i in range(6):
        for j in range(i):
            coupling = 0.5 * (w[i, j] + w[j, i])
            apart = not model.table and i >= 3 > j  # nothing closes the contact with the table
            if apart or abs(coupling) < ROUNDING * np.sqrt(w[i, i] * w[j, j]):
                coupling = 0.0
            w[i, j] = coupling
            w[j, i] = coupling
    return w


@compiled
def approach_of(
    lever: NDArray[np.float64], speed: float, n: NDArray[np.float64], c: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Contact velocities u(0) (6,) [m/s] of a cue that comes at `speed` to a ball at rest."""
    u = np.zeros(6)
    u[0] = speed * dot(n, c)
    u[1] = speed * dot(lever[0, 1], c)
    return u


@frugal
def weighted(weights: NDArray[np.float64], rows: NDArray[np.float64], total: NDArray[np.float64],
             ) -> None:
    """Write the sum of rows (6, 3) times weights (6,)."""
    for k in range(3):
        total[k] = 0.0
        for i in range(6):
            total[k] += weights[i] * rows[i, k]
