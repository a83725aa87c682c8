"""Strikes of many strokes by polynomials, which were fitted to solved strikes."""

from math import cos, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import inner
from billiard_shot.records import Array, Floats, Storage, Vector
from billiard_shot.scene.player import A, B, ELEVATION, SPEED

MOTION = 7  # numbers of a motion: velocity [m/s] and spin [rad/s]; speed of the cue [m/s]
VARIED = [A, B, ELEVATION, SPEED]  # columns of strokes that a polynomial depends on
# Of a, b and elevation. The motion over the speed changes little with the speed, so that the speed
# has few terms: times a linear polynomial of all four.
DEGREE = 3
EXPONENTS = np.array(
    [
        (i, j, k, n)
        for i in range(DEGREE + 1)
        for j in range(DEGREE + 1 - i)
        for k in range(DEGREE + 1 - i - j)
        for n in range(max(DEGREE - i - j - k, 1))
    ]
)  # of `VARIED` in each term, in the order of `write_motion`
TERMS = len(EXPONENTS)


class Mapped(NamedTuple):
    """
    Strikes of n strokes by polynomials of k cells, see planning/strike_map.py.

    Attributes
    ----------
    strokes : (n, 5) float array
        a, b, elevation, azimuth, speed, see `vectors_of`.
    number : (n,) int array
        The cell of each stroke; SOLVED if its strike is to be solved.
    middles, half_sizes : (k, 4) float arrays
        Of the cells: a and b (ball radii), elevation (rad), speed (m/s).
    coefficients : (k, TERMS, MOTION) float array
        Of the polynomials: the motion after strikes along +x, over the speed of the cue.

    """

    strokes: Array
    number: NDArray[np.int64]
    middles: Array
    half_sizes: Array
    coefficients: Array

    def part(self, part: slice | NDArray[np.integer]) -> 'Mapped':
        """Return some of the strokes; one stands for all."""
        if len(self.number) == 1:
            return self
        return self._replace(strokes=self.strokes[part], number=self.number[part])

    def stored(self, storage: Storage) -> 'Mapped':
        """Return them as compiled functions take them."""
        return Mapped(*map(storage.array, self))


SOLVED = -1
_NONE = np.zeros((0, len(VARIED)))
ALL_SOLVED = Mapped(
    np.zeros((1, 5)), np.array([SOLVED]), _NONE, _NONE, np.zeros((0, TERMS, MOTION))
)
"""For any number of strokes whose strikes are to be solved."""


@inner
def write_motion(
    stroke: Vector, mapped: Mapped, cell: int, velocity: Floats, spin: Floats
) -> float:
    """Write the motion of the ball after a stroke by a cell, and return the speed of the cue."""
    middle, half, coefficients = (
        mapped.middles[cell],
        mapped.half_sizes[cell],
        mapped.coefficients[cell],
    )
    x = (abs(stroke[0]) - middle[0]) / half[0]
    y, z = (stroke[1] - middle[1]) / half[1], (stroke[2] - middle[2]) / half[2]
    faster = (stroke[4] - middle[3]) / half[3]
    for k in range(3):
        velocity[k] = spin[k] = 0.0
    speed, term, in_x = 0.0, 0, 1.0
    for i in range(DEGREE + 1):
        in_y = in_x
        for j in range(DEGREE + 1 - i):
            in_z = in_y
            for k in range(DEGREE + 1 - i - j):
                product = in_z
                for _ in range(max(DEGREE - i - j - k, 1)):
                    for m in range(3):
                        velocity[m] += product * coefficients[term][m]
                        spin[m] += product * coefficients[term][3 + m]
                    speed += product * coefficients[term][MOTION - 1]
                    term += 1
                    product *= faster
                in_z *= z
            in_y *= y
        in_x *= x
    # the cells are those of a > 0
    sin_t, cos_t = sin(stroke[3]), cos(stroke[3])
    mirrored = -stroke[4] if stroke[0] < 0.0 else stroke[4]
    for m in range(3):
        velocity[m] *= mirrored if m == 1 else stroke[4]
        spin[m] *= stroke[4] if m == 1 else mirrored
    for vector in (velocity, spin):
        along, across = vector[0], vector[1]
        vector[0], vector[1] = cos_t * along - sin_t * across, sin_t * along + cos_t * across
    return speed * stroke[4]
