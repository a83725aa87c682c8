"""
Where balls, noses and cloth touch, or how far apart they are.

The contacts are those of the neighbours (neighbours.py).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from billiard_shot.shot.neighbours import FIXED, Neighbour, Nose

Array = NDArray[np.float64]


def ways_apart(neighbours: Sequence[Neighbour], positions: Array) -> Array:
    """
    Vectors (n, neighbours, 3) from what a ball may touch to its centre [m].

    For two balls the vector is that between the centres; else it begins at the nearest point of
    the nose or the cloth.
    """
    ways = np.zeros((len(positions), len(neighbours), 3))
    for j, each in enumerate(neighbours):
        place = positions[:, each.a]
        if each.b != FIXED:
            ways[:, j] = place - positions[:, each.b]
        elif each.nose is None:
            ways[:, j, 2] = place[:, 2]
        else:
            ways[:, j] = place - edges_near(each.nose, place)[0]
    return ways


def edges_near(nose: Nose, places: Array) -> tuple[Array, Array]:
    """Find the points of a nose nearest to places (n, 3) [m], and unit vectors along it there."""
    x, y = np.full(len(places), nose.x), np.full(len(places), nose.y)
    away = nose.away + nose.x * places[:, 0] + nose.y * places[:, 1]
    if nose.is_round:
        x, y = places[:, 0] - nose.x, places[:, 1] - nose.y
        distance = np.hypot(x, y)
        x, y, away = x / distance, y / distance, distance + nose.away
    height = np.full(len(places), nose.height)
    points = np.stack([places[:, 0] - x * away, places[:, 1] - y * away, height], axis=1)
    return points, np.stack([-y, x, np.zeros(len(places))], axis=1)


def gaps_of(neighbours: Sequence[Neighbour], positions: Array, radius: float) -> Array:
    """Distances (n, neighbours) at which balls are from what they may touch [m]."""
    touch = np.array([radius if each.b == FIXED else 2.0 * radius for each in neighbours])
    return sizes(ways_apart(neighbours, positions)) - touch


def sizes(vectors: Array) -> Array:
    """Lengths of vectors on the last axis; the sum has the same order for any shape."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.sqrt(x * x + y * y + z * z)
