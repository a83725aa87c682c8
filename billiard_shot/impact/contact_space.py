"""From bodies to contact space: velocities at the contacts, and how impulses change them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.bodies import Body, Contact, Vector
from billiard_shot.numerics import rounding
from billiard_shot.numerics.frames import contact_axes
from billiard_shot.numerics.vectors import cross_rows

PLANAR = 1e-12  # smallest singular value, relative to the largest, of directions in one plane


class System(NamedTuple):
    """B bodies and their N contacts as arrays, in the common frame."""

    positions: Vector  # (B, 3) m, centres of mass
    velocities: Vector  # (B, 3) m/s
    spins: Vector  # (B, 3) rad/s
    mobility: Vector  # (B, 6, 6) velocity and spin per impulse and angular impulse
    turns: NDArray[np.bool_]  # (B,) whether a body can turn
    guides: Vector  # (guided bodies, 3) unit vectors
    pairs: NDArray[np.int64]  # (N, 2) numbers of the bodies a and b of a contact
    points: Vector  # (N, 3) m
    normals: Vector  # (N, 3) unit vectors, from b into a


def system_of(bodies: Sequence[Body], contacts: Sequence[Contact]) -> System:
    """Collect the numbers of bodies and contacts."""
    return System(
        np.array([body.position for body in bodies]),
        np.array([body.velocity for body in bodies]),
        np.array([body.spin for body in bodies]),
        mobilities(bodies),
        np.array([body.inertia is not None for body in bodies]),
        np.array([body.guide for body in bodies if body.guide is not None]).reshape(-1, 3),
        np.array([(contact.a, contact.b) for contact in contacts]),
        np.array([contact.point for contact in contacts]),
        np.array([contact.normal for contact in contacts]),
    )


def contact_geometry(system: System) -> tuple[Vector, Vector]:
    """
    Find the axes of all contacts, and how they see the bodies' motion.

    Returns
    -------
    axes : (N, 3, 3) float array
        A row each for the normal and two tangents.
    jacobian : (bodies, 3 N, 6) float array
        Contact velocities per velocity and spin of each body.

    """
    arms = system.points[:, np.newaxis] - system.positions[system.pairs]
    axes = _frames(system, arms)
    return axes, _jacobians(len(system.positions), system.pairs, arms, axes)


def _frames(system: System, arms: Vector) -> Vector:
    """
    Axes of all contacts.

    `arms` (N, 2, 3) go from the centres of bodies a and b to the contact points [m]. Where all
    that happens stays in one plane, the second tangents are normal to it, and nothing couples to
    them. Otherwise any tangents do.
    """
    normals, pairs = system.normals, system.pairs
    turns = system.turns[pairs]
    directions = [
        normals,
        arms[turns],
        cross_rows(system.spins[pairs], arms)[turns],
        system.velocities[np.unique(pairs)],
        system.guides,
    ]
    vectors = np.concatenate(directions)
    lengths = np.linalg.norm(vectors, axis=1)
    units = vectors[lengths > 0.0] / lengths[lengths > 0.0, np.newaxis]
    at_least_three = np.concatenate([units, np.zeros((3, 3))])
    _, spread, axes = np.linalg.svd(at_least_three, full_matrices=False)
    across = axes[2] if spread[2] < PLANAR * spread[0] else np.zeros(3)
    rows = np.zeros((3 * len(normals), 3)).tolist()
    in_plane = cross_rows(across, normals).tolist()
    for i, normal in enumerate(normals.tolist()):
        contact_axes(normal, in_plane[i], in_plane[i], rows, 3 * i)
    return np.array(rows).reshape(-1, 3, 3)


def _jacobians(bodies: int, pairs: NDArray[np.int64], arms: Vector, axes: Vector) -> Vector:
    count = len(pairs)
    result = np.zeros((bodies, count, 3, 6))
    for side, sign in enumerate((1.0, -1.0)):
        body, contact = pairs[:, side], np.arange(count)
        result[body, contact, :, :3] = sign * axes
        result[body, contact, :, 3:] = sign * cross_rows(arms[:, side, np.newaxis], axes)
    return result.reshape(bodies, 3 * count, 6)


def response(jacobian: Vector, mobility: Vector) -> Vector:
    """
    W (3 N, 3 N) [1/kg]: the contact velocities that unit contact impulses cause.

    W is symmetric, and couplings that are only rounding are made exactly zero.
    """
    moved = np.einsum('bik,bkl->bil', jacobian, mobility)
    rows = jacobian.shape[1]
    w = np.zeros((rows, rows))
    for body in range(len(jacobian)):  # all at once takes ten times as long for a rack
        own = np.flatnonzero(jacobian[body].any(axis=1))
        w[np.ix_(own, own)] += np.einsum('il,jl->ij', moved[body, own], jacobian[body, own])
    w = 0.5 * (w + w.T)
    size = np.sqrt(np.diag(w))
    w[np.abs(w) <= rounding.COUPLING * np.outer(size, size)] = 0.0
    return w


def mobilities(bodies: Sequence[Body]) -> Vector:
    """Velocity and spin per impulse and angular impulse of each body: (bodies, 6, 6)."""
    result = np.zeros((len(bodies), 6, 6))
    for i, body in enumerate(bodies):
        result[i, :3, :3] = body.inverse_mass()
        result[i, 3:, 3:] = body.inverse_inertia()
    return result
