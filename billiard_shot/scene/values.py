"""Values as people give them: numbers of any type, NumPy's too, and objects of one type."""

import math
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene.errors import refused

LARGEST = 1e12
"""
Largest coordinate [m], speed [m/s] and spin [rad/s].

At this size rounding is as large as the tolerance of predictions, and powers do not overflow yet.
"""


def as_float(value: object) -> float:
    """Return a number as a float; infinite if it is too large, NaN if it is not a number."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.inf


def as_floats(values: object) -> NDArray[np.float64]:
    """Return numbers as an array of floats; an empty array if they are not numbers."""
    try:
        return np.ascontiguousarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        return np.empty(0)


def whole(name: str, value: object, minimum: int) -> int:
    """Return a whole number; raise ValueError for other values, or if it is below `minimum`."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < minimum:
        raise refused(value, f'a whole number, at least {minimum}', name)
    return int(value)


def positive(name: str, value: object, unit: str) -> float:
    """Return a finite number above 0; raise ValueError for other values."""
    number = as_float(value)
    if not 0.0 < number < math.inf:
        raise refused(value, 'finite and above 0', name, unit)
    return number


def one_or_many(value: object) -> tuple[Any, ...]:
    """Return the elements of a list, tuple or set (sorted as text); of another value, itself."""
    if isinstance(value, set | frozenset):
        return tuple(sorted(value, key=str))
    return tuple(value) if isinstance(value, tuple | list) else (value,)


def check_type(name: str, value: object, kind: type) -> None:
    """Raise ValueError if a value is of another type."""
    if not isinstance(value, kind):
        raise refused(value, f'a {kind.__name__}', name)
