"""Vectors, contact frames, angles, small dense solvers, the same compiled and interpreted."""

import math
from math import inf, nan, sqrt
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import inner
from billiard_shot.records import Floats, Vector

PARALLEL = 1e-12  # sine of the angle between two unit vectors below which they have one direction


@inner
def dot(a: Vector, b: Vector) -> float:
    """Scalar product in space."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inner
def unit(v: Vector, direction: Floats) -> float:
    """Write the direction of a vector, and return its length; both NaN if it is 0 or infinite."""
    square = dot(v, v)
    length = sqrt(square) if 0.0 < square < inf else nan
    for k in range(3):
        direction[k] = v[k] / length
    return length


@inner
def cross(a: Vector, b: Vector, product: Floats) -> None:
    """Write the vector product."""
    product[0] = a[1] * b[2] - a[2] * b[1]
    product[1] = a[2] * b[0] - a[0] * b[2]
    product[2] = a[0] * b[1] - a[1] * b[0]


def cross_rows(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vector products of arrays (..., 3); for small arrays np.cross takes three times as long."""
    return a[..., (1, 2, 0)] * b[..., (2, 0, 1)] - a[..., (2, 0, 1)] * b[..., (1, 2, 0)]


@inner
def perpendicular_unit(v: Vector, n: Vector, unit: Floats) -> bool:
    """Write the unit vector of the part of v that is normal to n; False if that part is zero."""
    for i in range(3):
        unit[i] = v[i]
    for _ in range(2):  # if v is nearly along n, the second pass removes what rounding has left
        along = dot(unit, n)
        for i in range(3):
            unit[i] -= along * n[i]
        length = sqrt(dot(unit, unit))
        if length <= PARALLEL:
            return False
        for i in range(3):
            unit[i] /= length
    return True


@inner
def contact_axes(n: Vector, first: Vector, second: Vector, axes: Floats, at: int) -> None:
    """
    Write the axes of a contact as three rows from row `at` on: n and two tangents.

    The first tangent is in the plane of n and `first`, or of n and `second` if `first` is parallel
    to n, or else in any direction. The second tangent is normal to that plane.
    """
    tangent, other = axes[at + 1], axes[at + 2]
    for i in range(3):
        axes[at][i] = n[i]
    if not perpendicular_unit(first, n, tangent) and not perpendicular_unit(second, n, tangent):
        other[0], other[1], other[2] = (1.0, 0.0, 0.0) if abs(n[0]) < 0.6 else (0.0, 1.0, 0.0)
        perpendicular_unit(other, n, tangent)
    cross(n, tangent, other)


Angle = TypeVar('Angle', float, NDArray[np.float64])


@inner
def wrapped(angle: Angle) -> Angle:
    """Return the same angle above -pi and up to pi [rad], or the same angles (n,)."""
    turned: Angle = angle + math.tau * np.floor((math.pi - angle) / math.tau)
    return turned


RANK = 1e-12  # eigenvalues below this fraction of the largest count as zero


@inner
def pseudo_inverse(a: Floats, inverse: Floats, v: Floats, n: int) -> None:
    """
    Write the Moore-Penrose inverse of a symmetric, positive semidefinite (n, n) matrix.

    `a` is used up; `v` is scratch, for the eigenvectors.

    Cyclic Jacobi rotations (Golub, Van Loan, Matrix Computations, section 8.5). For contacts that
    share one constraint this is the least-norm solution, which does not depend on their numbering.
    """
    for i in range(n):
        for j in range(n):
            v[i][j] = 1.0 if i == j else 0.0
    for _ in range(60):
        off = 0.0
        size = 0.0
        for i in range(n):
            size += abs(a[i][i])
            for j in range(i):
                off += abs(a[i][j])
        if off <= 1e-17 * size:
            break
        for p in range(n - 1):
            for q in range(p + 1, n):
                if a[p][q] != 0.0:
                    rotate(a, v, n, p, q)
    largest = 0.0
    for i in range(n):
        largest = max(largest, a[i][i])
    for i in range(n):
        for j in range(n):
            inverse[i][j] = 0.0
    for k in range(n):
        if a[k][k] > RANK * largest:
            for i in range(n):
                for j in range(n):
                    inverse[i][j] += v[i][k] * v[j][k] / a[k][k]


@inner
def rotate(a: Floats, v: Floats, n: int, p: int, q: int) -> None:
    """Zero a[p][q] by a rotation in the plane of p and q, accumulated in v."""
    theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q]
    t = 1.0 / (abs(theta) + sqrt(theta * theta + 1.0))
    if theta < 0.0:
        t = -t
    c = 1.0 / sqrt(t * t + 1.0)
    s = t * c
    for k in range(n):
        x, y = a[k][p], a[k][q]
        a[k][p], a[k][q] = c * x - s * y, s * x + c * y
    for k in range(n):
        x, y = a[p][k], a[q][k]
        a[p][k], a[q][k] = c * x - s * y, s * x + c * y
        x, y = v[k][p], v[k][q]
        v[k][p], v[k][q] = c * x - s * y, s * x + c * y
    a[p][q] = 0.0
    a[q][p] = 0.0


@inner
def solve_in_place(a: Floats, b: Floats, n: int) -> bool:
    """Solve n equations a x = b by Gaussian elimination with pivots; False if a is singular."""
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(a[i][k]) > abs(a[pivot][k]):
                pivot = i
        if not abs(a[pivot][k]) > 1e-300:
            return False
        if pivot != k:
            for j in range(k, n):
                a[k][j], a[pivot][j] = a[pivot][j], a[k][j]
            b[k], b[pivot] = b[pivot], b[k]
        for i in range(k + 1, n):
            factor = a[i][k] / a[k][k]
            if factor != 0.0:
                for j in range(k + 1, n):
                    a[i][j] -= factor * a[k][j]
                b[i] -= factor * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= a[k][j] * b[j]
        b[k] /= a[k][k]
    return True
