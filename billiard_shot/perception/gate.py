"""
The gate for balls that other programs name: how many, which names, where, and how surely.

Every check raises ValueError with the field, its value and the allowed range. Balls and names are
counted first, because they are compared in pairs later.
"""

from collections.abc import Sequence
import math

from billiard_shot.scene.errors import must_be
from billiard_shot.scene.fields import fits_name, LONGEST_NAME

MAX_BALLS = 64
"""Largest number of balls on a table; snooker has 22."""

MAX_COORDINATE = 10.0
"""Largest distance of a ball from the middle of the table along an axis [m]."""

MAX_DEVIATION = 5e-3
"""Largest standard deviation of x and y of a ball [m]; a ball that is known worse is not used."""

MAX_LENGTH_ERROR = 0.005
"""Largest deviation of the length of a quaternion from 1; tf2 allows 0.01 in its square."""


def check_count(field: str, things: Sequence[object]) -> None:
    """Check that there are not more balls, or names of balls, than a table can have."""
    if len(things) > MAX_BALLS:
        raise ValueError(f'{field} must have at most {MAX_BALLS} elements, got {len(things)}')


def check_name(field: str, name: str) -> None:
    """Check the name of a ball or a shot, which appears in logs and terminals."""
    if not fits_name(name):
        allowed = f'1 to {LONGEST_NAME} printable characters'
        raise ValueError(f'{field} {must_be(allowed, name)}')


def check_position(field: str, position: Sequence[float]) -> None:
    """Check a position (x, y, z) [m]."""
    for axis, value in zip('xyz', position, strict=True):
        if not abs(value) <= MAX_COORDINATE:
            allowed = f'from {-MAX_COORDINATE:g} to {MAX_COORDINATE:g} m'
            raise ValueError(f'{field}.{axis} must be {allowed}, got {value}')


def plane_covariance(field: str, values: Sequence[float]) -> tuple[float, float, float]:
    """
    Check the part for x and y of a covariance (9,), row by row [m^2]; return its xx, xy and yy.

    Heights are not used, so their errors do not matter.
    """
    xx, xy, _, yx, yy, *_ = values
    largest = MAX_DEVIATION**2
    if 0.0 <= xx <= largest and 0.0 <= yy <= largest:
        product = math.sqrt(xx) * math.sqrt(yy)
        rounding = 1e-6 * product + 1e-18  # m^2
        if abs(xy) <= product + rounding and abs(xy - yx) <= rounding:
            return xx, xy, yy
    raise ValueError(
        f'{field} must be symmetric and positive semi-definite for x and y, with standard '
        f'deviations of at most {1e3 * MAX_DEVIATION:g} mm, got {list(values)} m^2'
    )


def check_systematic_error(field: str, value: float) -> None:
    """Check the systematic error of a position [m]."""
    if not 0.0 <= value <= MAX_DEVIATION:
        raise ValueError(f'{field} must be from 0 to {MAX_DEVIATION:g} m, got {value}')


def check_quaternion(field: str, values: Sequence[float]) -> None:
    """Check that a quaternion is a rotation: its length is 1."""
    if not abs(math.hypot(*values) - 1.0) <= MAX_LENGTH_ERROR:
        raise ValueError(
            f'{field} must have the length 1, within {MAX_LENGTH_ERROR:g}, got {tuple(values)}'
        )
