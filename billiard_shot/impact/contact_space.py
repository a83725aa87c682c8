"""From bodies to contact space: velocities at the contacts, and how impulses change them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.bodies import Body, Contact
from billiard_shot.numerics import rounding
from billiard_shot.numerics.vectors import cross_rows, PARALLEL
from billiard_shot.records import Array

PLANAR = 1e-12  # smallest singular value, relative to the largest, of directions in one plane


class System(NamedTuple):
    """B bodies and their N contacts as arrays, in the common frame."""

    positions: Array  # (B, 3) m, centres of mass
    velocities: Array  # (B, 3) m/s
    spins: Array  # (B, 3) rad/s
    mobility: Array  # (B, 6, 6) velocity and spin per impulse and angular impulse
    turns: NDArray[np.bool_]  # (B,) whether a body can turn
    guides: Array  # (guided bodies, 3) unit vectors
    pairs: NDArray[np.int64]  # (N, 2) indices of the bodies a and b of a contact
    points: Array  # (N, 3) m
    normals: Array  # (N, 3) unit vectors, from b into a

    def arms(self) -> Array:
        """From the centres of bodies a and b to the contact points (N, 2, 3) [m]."""
        return self.points[:, np.newaxis] - self.positions[self.pairs]


def system_of(bodies: Sequence[Body], contacts: Sequence[Contact]) -> System:
    """Write bodies and contacts as arrays."""
    return System(
        np.array([body.position for body in bodies]),
        np.array([body.velocity for body in bodies]),
        np.array([body.spin for body in bodies]),
        mobilities(bodies),
        np.array([body.inertia is not None for body in bodies]),
        np.array([body.guide for body in bodies if body.guide is not None]).reshape(-1, 3),
        pairs=np.array([(contact.a, contact.b) for contact in contacts]),
        points=np.array([contact.point for contact in contacts]),
        normals=np.array([contact.normal for contact in contacts]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class ContactSpace:
    """
    A system in the contact space of its N contacts.

    Attributes
    ----------
    axes : (N, 3, 3) float array
        A row each for the normal and two tangents.
    delassus : (3 N, 3 N) float array
        W [1/kg]: the contact velocities that unit contact impulses cause.
    approach : (3 N,) float array
        Contact velocities [m/s].

    """

    axes: Array
    delassus: Array
    approach: Array


def contact_space(system: System) -> ContactSpace:
    """
    Compute the contact space of a system.

    W is symmetric. Its couplings, and contact velocities, that are only rounding are exactly zero.
    """
    axes = _axes(system)
    count, bodies = len(system.pairs), len(system.positions)
    by_contact = np.zeros((count, 3, bodies, 6))  # contact velocities per velocity and spin
    arms = system.arms()
    for side, sign in enumerate((1.0, -1.0)):
        rows = np.concatenate([axes, cross_rows(arms[:, side, np.newaxis], axes)], axis=2)
        by_contact[np.arange(count), :, system.pairs[:, side]] = sign * rows
    jacobian = by_contact.reshape(3 * count, bodies, 6)
    moved = np.einsum('jbk,bkl->jbl', jacobian, system.mobility)
    flat = jacobian.reshape(3 * count, -1)
    lower = np.tril(moved.reshape(flat.shape) @ flat.T)
    delassus = lower + np.tril(lower, -1).T
    sizes = np.sqrt(delassus.diagonal())
    rounded = np.abs(delassus) <= rounding.COUPLING * np.outer(sizes, sizes)
    delassus[rounded & ~np.eye(3 * count, dtype=bool)] = 0.0
    approach = flat @ np.concatenate([system.velocities, system.spins], axis=1).ravel()
    approach[np.abs(approach) <= rounding.SUM * np.abs(system.velocities).max()] = 0.0
    return ContactSpace(axes, delassus, approach)


def _axes(system: System) -> Array:
    """
    Compute the axes (N, 3, 3) of contacts: normals and two tangents.

    If all motion is in one plane, the second tangents are normal to it, so that nothing couples to
    them. Otherwise first tangents point along the slip.
    """
    normals, across = system.normals, _normal_of_plane(system)
    if across.any():
        along = cross_rows(across, normals)
    else:
        spins = cross_rows(system.spins[system.pairs], system.arms())
        sides = system.velocities[system.pairs] + spins
        along = sides[:, 0] - sides[:, 1]
    tangents = _perpendicular(along, normals)
    any_other = np.eye(3)[np.abs(normals).argmin(axis=1)]
    none = ~tangents.any(axis=1)
    tangents[none] = _perpendicular(any_other, normals)[none]
    return np.stack([normals, tangents, cross_rows(normals, tangents)], axis=1)


def _perpendicular(vectors: Array, normals: Array) -> Array:
    """Return the directions (N, 3) of the parts of vectors normal to others, or zeros."""
    result = vectors
    for _ in range(2):  # the second pass removes what rounding has left
        result = result - (result * normals).sum(axis=1, keepdims=True) * normals
        lengths = np.linalg.norm(result, axis=1, keepdims=True)
        allowed = PARALLEL * np.linalg.norm(vectors, axis=1, keepdims=True)
        result = np.where(lengths > allowed, result / np.where(lengths > 0.0, lengths, 1.0), 0.0)
        vectors = result
    return result


def _normal_of_plane(system: System) -> Array:
    """
    Find the normal (3,) of the plane of all motion; zero if the motion is not planar.

    If the second tangents are normal to that plane, nothing couples to them.
    """
    arms, pairs = system.arms(), system.pairs
    turns = system.turns[pairs]
    directions = [
        system.normals,
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
    normal: Array = axes[2] if spread[2] < PLANAR * spread[0] else np.zeros(3)
    return normal


def velocity_changes(system: System, impulses: Array) -> Array:
    """Compute the changes of velocity and spin (B, 6) by impulses (N, 3) on bodies a [N s]."""
    arms, given = system.arms(), np.zeros((len(system.positions), 6))
    for side, sign in enumerate((1.0, -1.0)):
        moments = cross_rows(arms[:, side], impulses)
        np.add.at(given, system.pairs[:, side], sign * np.hstack([impulses, moments]))
    changes: Array = np.einsum('bkl,bl->bk', system.mobility, given)
    return changes


def mobilities(bodies: Sequence[Body]) -> Array:
    """Velocity and spin per impulse and angular impulse of each body: (bodies, 6, 6)."""
    result = np.zeros((len(bodies), 6, 6))
    for i, body in enumerate(bodies):
        result[i, :3, :3] = body.inverse_mass()
        result[i, 3:, 3:] = body.inverse_inertia()
    return result
