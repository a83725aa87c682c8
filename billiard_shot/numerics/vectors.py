"""Vectors, contact frames and angles, the same compiled and interpreted."""

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
