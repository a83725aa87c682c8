"""
Where cue, balls, noses and cloth touch, or how far apart they are, and what an impulse there does.

Contacts are numbered: TIP, TABLE, then the neighbours' (neighbours.py). Velocities of the bodies
are one vector: the tip's, those of the k balls, and their spins, 3 + 6 k numbers.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.contact_space import without_rounding
from billiard_shot.numerics import rounding
from billiard_shot.numerics.vectors import cross_rows
from billiard_shot.shot.model import StrikeModel, TABLE, TIP
from billiard_shot.shot.neighbours import FIXED, Neighbour, UP
from billiard_shot.table.params import BallClothParams

Array = NDArray[np.float64]


def shares(neighbours: Sequence[Neighbour], balls: int) -> Array:
    """Whether each contact pushes each ball along its normal, 1, against it, -1, or not, 0."""
    share = np.zeros((TABLE + 1 + len(neighbours), balls))
    share[TIP, 0], share[TABLE, 0] = -1.0, 1.0
    for row, each in zip(share[TABLE + 1 :], neighbours, strict=True):
        row[each.a] = 1.0
        if each.b != FIXED:
            row[each.b] = -1.0
    return share


def ways_apart(neighbours: Sequence[Neighbour], positions: Array) -> Array:
    """
    Vectors (n, neighbours, 3) from what a ball may touch to its centre [m].

    For two balls the vector is that between the centres; else it begins at the nearest point of
    the nose or the cloth.
    """
    ways = np.zeros((len(positions), len(neighbours), 3))
    for j, each in enumerate(neighbours):
        place, nose = positions[:, each.a], each.nose
        if each.b != FIXED:
            ways[:, j] = place - positions[:, each.b]
        elif nose is None:
            ways[:, j, 2] = place[:, 2]
        else:
            x, y = np.full(len(place), nose.x), np.full(len(place), nose.y)
            away = nose.away + nose.x * place[:, 0] + nose.y * place[:, 1]
            if nose.is_round:
                x, y = place[:, 0] - nose.x, place[:, 1] - nose.y
                distance = np.hypot(x, y)
                x, y, away = x / distance, y / distance, distance + nose.away
            ways[:, j] = np.stack([x * away, y * away, place[:, 2] - nose.height], axis=1)
    return ways


def gaps_of(neighbours: Sequence[Neighbour], positions: Array, radius: float) -> Array:
    """Distances (n, neighbours) at which balls are from what they may touch [m]."""
    touch = np.array([radius if each.b == FIXED else 2.0 * radius for each in neighbours])
    return sizes(ways_apart(neighbours, positions)) - touch


def frames_of(normals: Array, axes: Array) -> Array:
    """
    Add two tangents to the normals (n, contacts, 3): frames (n, contacts, 3, 3), as rows.

    Where the cue, the normal of the tip and the vertical are in one plane, the second tangents of
    TIP and TABLE are normal to it. The first tangents of all others are upright, or along x.
    """
    side = cross_rows(UP, axes)
    width = sizes(side)
    side[width < rounding.COUPLING] = np.array([0.0, 1.0, 0.0])
    side /= np.where(width < rounding.COUPLING, 1.0, width)[:, np.newaxis]
    up = UP - normals[..., 2:] * normals
    size = sizes(up)[..., np.newaxis]
    first = np.where(size > 0.0, up / np.where(size > 0.0, size, 1.0), np.array([1.0, 0.0, 0.0]))
    tip = cross_rows(side, normals[:, TIP])
    first[:, TIP] = tip / sizes(tip)[:, np.newaxis]
    first[:, TABLE] = cross_rows(side, normals[:, TABLE])
    return np.stack([normals, first, cross_rows(normals, first)], axis=-2)


def jacobian_of(frames: Array, share: Array, radius: float) -> Array:
    """Matrices (n, 3 contacts, 3 + 6 k) that turn velocities of the bodies into contacts'."""
    n, count = frames.shape[:2]
    pushed = frames[:, :, :, np.newaxis] * share[:, np.newaxis, :, np.newaxis]
    turning = -radius * cross_rows(frames[:, :, :1], frames)[:, :, :, np.newaxis]
    turned = turning * np.abs(share)[:, np.newaxis, :, np.newaxis]
    tip = np.zeros((n, count, 3, 3))
    tip[:, TIP] = frames[:, TIP]
    parts = [tip, pushed.reshape(n, count, 3, -1), turned.reshape(n, count, 3, -1)]
    return np.concatenate(parts, axis=-1).reshape(n, 3 * count, -1)


def tip_response(model: StrikeModel, axes: Array) -> Array:
    """Velocities (n, 3, 3) of the tip per impulse: the whole cue along it, its end across."""
    along = axes[:, :, np.newaxis] * axes[:, np.newaxis]
    return along / model.cue_mass + model.inverse_end_mass * (np.eye(3) - along)


def mobility_of(jacobian: Array, tip: Array, ball: BallClothParams) -> Array:
    """Velocities of the bodies (n, 3 + 6 k, 3 contacts) per contact impulse."""
    columns = jacobian.transpose(0, 2, 1).copy()
    balls = (columns.shape[1] - 3) // 2
    columns[:, :3] = tip @ columns[:, :3]
    columns[:, 3 : 3 + balls] /= ball.mass
    columns[:, 3 + balls :] /= ball.inertia
    return columns


def delassus_of(jacobian: Array, mobility: Array) -> Array:
    """Velocities (n, 3 contacts, 3 contacts) of contacts per contact impulse [1/kg]."""
    return without_rounding(jacobian @ mobility)


def times(matrices: Array, vectors: Array) -> Array:
    """Multiply matrices (n, i, j) with vectors (n, j), each as it would be alone."""
    product: Array = (matrices @ vectors[:, :, np.newaxis])[:, :, 0]
    return product


def sizes(vectors: Array) -> Array:
    """Lengths of vectors on the last axis; the sum has the same order for any shape."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.sqrt(x * x + y * y + z * z)
