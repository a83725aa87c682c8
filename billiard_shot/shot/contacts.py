"""
The two contacts of a strike in contact space: cue on ball at r n, and ball on table at -r z.

A row of `levers` says how one contact velocity (per contact: normal, first and second tangential)
depends on the velocities of the bodies, and, read as a column, how a contact impulse acts on them:
    u = C v_cue + B v + S w ,   W = C M_cue^-1 C' + B B' / m + S S' / I   (paper, equations 16-18).
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.shot.model import Model

ROUNDING = 8 * 2.0**-52


@compiled
def dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Scalar product in space."""
    product: float = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


@compiled
def cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vector product."""
    return np.array([
        a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    ])


@compiled
def across(v: NDArray[np.float64], n: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vector of the part of a unit vector v that is normal to n; zero if that is rounding."""
    part = v - dot(v, n) * n
    length = np.sqrt(dot(part, part))
    return part / length if length > 1e-12 else np.zeros(3)


@compiled
def frame(n: NDArray[np.float64], first: NDArray[np.float64], second: NDArray[np.float64],
          ) -> NDArray[np.float64]:
    """
    Axes of a contact as rows: n and two tangential ones.

    The first of those is in the plane of n and `first`, or `second` where that is parallel to n,
    or else anywhere.
    """
    tangent = across(first, n)
    if dot(tangent, tangent) == 0.0:
        tangent = across(second, n)
    if dot(tangent, tangent) == 0.0:
        tangent = across(np.array([1.0, 0.0, 0.0]), n)
    axes = np.empty((3, 3))
    axes[0] = n
    axes[1] = tangent
    axes[2] = cross(n, tangent)
    return axes


@compiled
def levers(radius: float, n: NDArray[np.float64], c: NDArray[np.float64]) -> NDArray[np.float64]:
    """
    C, B and S, (6, 3) each, for a stroke along the unit vector c.

    The tip's first tangent points along its slip. Where n, c and the vertical are in one plane, so
    are both first tangents, and nothing couples to the second ones.
    """
    z = np.array([0.0, 0.0, 1.0])
    tip, table = frame(n, c, z), frame(z, n, c)
    result = np.zeros((3, 6, 3))
    for i in range(3):
        result[0, i] = tip[i]
        result[1, i] = -tip[i]
        result[1, 3 + i] = table[i]
        result[2, i] = -radius * cross(n, tip[i])
        result[2, 3 + i] = -radius * cross(z, table[i])
    return result


@compiled
def yielding(model: Model, c: NDArray[np.float64], impulse: NDArray[np.float64],
             ) -> NDArray[np.float64]:
    """
    Change of the tip's velocity by an impulse on it.

    Along its axis c the whole cue has to move, across it only the light, flexible end.
    """
    along = dot(c, impulse)
    return along / model.cue_mass * c + model.softness * (impulse - along * c)


@compiled
def response_of(model: Model, c: NDArray[np.float64], lever: NDArray[np.float64],
                ) -> NDArray[np.float64]:
    """W (6, 6) [1/kg]. Couplings that are only rounding are made exactly zero."""
    ball = model.surface
    w = np.empty((6, 6))
    for i in range(6):
        cue = yielding(model, c, lever[0, i])
        for j in range(6):
            w[i, j] = (dot(lever[0, j], cue) + dot(lever[1, j], lever[1, i]) / ball.mass
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


@compiled
def weighted(weights: NDArray[np.float64], rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sum of rows (6, 3) times weights (6,)."""
    total = np.zeros(3)
    for i in range(6):
        total += weights[i] * rows[i]
    return total
