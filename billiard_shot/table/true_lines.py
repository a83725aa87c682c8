"""
Where balls go on after an impact that took time: on their true lines.

An impact is an event at the time when it begins. A ball that goes back from its end with its
velocity after it, for as long as it lasted, gets to a place from which it is where it should be in
time. Of balls that met, these places overlap: such balls are moved along their lines.
"""

from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.numerics.vectors import dot
from billiard_shot.records import Floats, Storage

MAX_SWEEPS = 200
CLEARANCE = 1e-6  # m, between balls that are moved
LEAST = 0.1  # sum of the squares of two cosines


def _example(storage: Storage) -> tuple[Any, ...]:
    """Two balls that overlap."""
    return (
        storage.array([[0.0, 0.0, 0.0], [1.5, 0.0, 0.0]]),
        storage.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]),
        2.0,
        storage.zeros(3),
    )


@entry(_example)
def set_apart(places: Floats, lines: Floats, diameter: float, normal: Floats) -> bool:
    """
    Move balls along their lines until none overlap.

    Parameters
    ----------
    places : (B, 3) floats, changed
        [m]
    lines : (B, 3) floats
        Unit vectors, or zero for a ball at rest.
    diameter : float
        [m]
    normal : (3,) floats
        Scratch.

    Returns
    -------
    bool
        Whether none overlap in the end.

    """
    for _ in range(MAX_SWEEPS):
        overlap = False
        for i in range(len(places)):
            for j in range(i):
                square = 0.0
                for k in range(3):
                    normal[k] = places[i][k] - places[j][k]
                    square += normal[k] * normal[k]
                if square < diameter * diameter:
                    overlap = True
                    part(places[i], places[j], lines[i], lines[j], normal, sqrt(square), diameter)
        if not overlap:
            return True
    return False


@inner
def part(
    a: Floats, b: Floats, v: Floats, w: Floats, normal: Floats, distance: float, diameter: float
) -> None:
    """
    Move two balls that overlap, each by as much as its own way opens the pair.

    If hardly any of their ways does, they are moved along the normal.
    """
    for k in range(3):
        normal[k] /= distance
    space = diameter + CLEARANCE - distance
    x, y = dot(normal, v), dot(normal, w)
    share = x * x + y * y
    for k in range(3):
        if share > LEAST:
            a[k] += space / share * x * v[k]
            b[k] -= space / share * y * w[k]
        else:
            a[k] += 0.5 * space * normal[k]
            b[k] -= 0.5 * space * normal[k]


def without_overlap(
    places: NDArray[np.float64], velocities: NDArray[np.float64], diameter: float
) -> NDArray[np.float64] | None:
    """
    Move balls along their lines until none overlap.

    Parameters
    ----------
    places : (B, 3) float array
        [m]
    velocities : (B, 3) float array
        [m/s]
    diameter : float
        [m]

    Returns
    -------
    (B, 3) float array, or None
        [m] None: they could not be set apart.

    """
    speeds = np.linalg.norm(velocities, axis=1, keepdims=True)
    run = set_apart.current()
    storage = run.storage
    moved = storage.array(places)
    lines = storage.array(velocities / np.where(speeds > 0.0, speeds, 1.0))
    return np.array(moved) if run(moved, lines, diameter, storage.zeros(3)) else None
