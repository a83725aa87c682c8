"""
The gate for balls that other programs name: how many, which names, where, and how surely.

Numbers are counted first, because balls are compared in pairs later. Every check raises ValueError
with the field, its value and the allowed range.
"""

from collections.abc import Sequence
import math

from billiard_shot.scene.errors import must_be

MAX_BALLS = 64
"""Largest number of balls on a table; snooker has 22."""

MAX_NAME_LENGTH = 64
"""Largest number of characters of the name of a ball or a shot."""

MAX_COORDINATE = 10.0
"""Largest distance of a ball from the middle of the table along an axis [m]."""

MAX_DEVIATION = 5e-3
"""Largest standard deviation of x and y of a ball [m]; a ball that is known worse is not used."""

MAX_LENGTH_ERROR = 0.005
"""Largest deviation of the length of a quaternion from 1; tf2 allows 0.01 in its square."""

ROUNDING = 1e-6, 1e-18
"""Errors of a covariance: relative to the product of both standard deviations, and in m^2."""


def check_count(field: str, things: Sequence[object]) -> None:
    """Check that there are not more balls, or names of balls, than a table can have."""
    if len(things) > MAX_BALLS:
        raise ValueError(f'{field} must have at most {MAX_BALLS} elements, got {len(things)}')


def check_name(field: str, name: str) -> None:
    """Check the name of a ball or a shot, which appears in logs and terminals."""
    if not (0 < len(name) <= MAX_NAME_LENGTH and name.isprintable()):
        allowed = f'1 to {MAX_NAME_LENGTH} printable characters'
        raise ValueError(f'{field} {must_be(allowed, name)}')


def check_names(field: str, names: Sequence[str]) -> None:
    """Check the names of several balls."""
    check_count(field, names)
    for name in names:
        check_name(field, name)


def check_position(field: str, position: Sequence[float]) -> None:
    """Check a position (x, y) or (x, y, z) [m]."""
    for axis, value in zip('xyz', position, strict=False):
        if not abs(value) <= MAX_COORDINATE:
            raise ValueError(
                f'{field}.{axis} must be from {-MAX_COORDINATE:g} to {MAX_COORDINATE:g} m, '
                f'got {value}'
            )


def plane_covariance(field: str, values: Sequence[float]) -> tuple[float, float, float]:
    """
    Check the covariance (9,) of a position, row by row [m^2]; return its xx, xy and yy.

    The standard deviation of the height may be large, because heights are not used.
    """
    variances = values[0], values[4], values[8]
    if not all(0.0 <= each < math.inf for each in variances):
        raise ValueError(f'{field} must have finite variances of at least 0 m^2, got {variances}')
    deviations = [math.sqrt(each) for each in variances]
    if not max(deviations[:2]) <= MAX_DEVIATION:
        raise ValueError(
            f'{field} must have standard deviations of x and y of at most '
            f'{1e3 * MAX_DEVIATION:g} mm, got {1e3 * max(deviations[:2]):.3g} mm'
        )
    a, b, c = (
        _correlation(values[3 * i + k], values[3 * k + i], deviations[i] * deviations[k])
        for i, k in ((0, 1), (0, 2), (1, 2))
    )
    # the determinant of a matrix of correlations
    if not 1.0 + 2.0 * a * b * c - a * a - b * b - c * c >= -ROUNDING[0]:
        raise ValueError(
            f'{field} must be symmetric and positive semi-definite, got {list(values)} m^2'
        )
    return values[0], values[1], values[4]


def _correlation(upper: float, lower: float, scale: float) -> float:
    """Return the correlation of two coordinates; NaN if a covariance cannot have the elements."""
    error = ROUNDING[0] * scale + ROUNDING[1]
    if not (abs(upper) <= scale + error and abs(upper - lower) <= error):
        return math.nan
    return min(max(upper / scale, -1.0), 1.0) if scale else 0.0


def check_quaternion(field: str, values: Sequence[float]) -> None:
    """Check that a quaternion is a rotation: its length is 1."""
    if not abs(math.hypot(*values) - 1.0) <= MAX_LENGTH_ERROR:
        raise ValueError(
            f'{field} must have a length from {1.0 - MAX_LENGTH_ERROR:g} to '
            f'{1.0 + MAX_LENGTH_ERROR:g}, got {tuple(values)}'
        )
