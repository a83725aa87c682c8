"""Angles as one of many that differ by full turns."""

import math
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import inner

Angle = TypeVar('Angle', float, NDArray[np.float64])


@inner
def wrapped(angle: Angle) -> Angle:
    """Return the same angle above -pi and up to pi [rad], or the same angles (n,)."""
    turned: Angle = angle + math.tau * np.floor((math.pi - angle) / math.tau)
    return turned
