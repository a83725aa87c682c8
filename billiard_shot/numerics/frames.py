"""The frame of a contact: its normal and two tangents."""

from billiard_shot.compiled import inner
from billiard_shot.numerics.vectors import cross, perpendicular_unit
from billiard_shot.records import Floats, Vector


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
