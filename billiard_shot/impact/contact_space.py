"""From bodies to contact space: velocities at the contacts, and how impulses change them."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.impact.bodies import Body, Contact
from billiard_shot.numerics import rounding
from billiard_shot.numerics.frames import contact_axes
from billiard_shot.numerics.vectors import cross, cross_rows, dot
from billiard_shot.records import Array, Floats, Storage

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
        np.array([(contact.a, contact.b) for contact in contacts]),
        np.array([contact.point for contact in contacts]),
        np.array([contact.normal for contact in contacts]),
    )


class Written(NamedTuple):
    """Output of `write_contact_space` for N contacts."""

    axes: Floats  # (3 N, 3) three rows a contact: the normal and two tangents
    # (2 N, 3, 6) of bodies a and b of each contact: contact velocities per velocity and spin, and
    # per impulse and angular impulse
    jacobian: Floats
    moved: Floats
    # (3 N, 3 N) W [1/kg]: the contact velocities that unit contact impulses cause. W is symmetric,
    # and couplings that are only rounding are exactly zero.
    delassus: Floats
    approach: Floats  # (3 N,) m/s, contact velocities; those that are only rounding are zero


def _room(storage: Storage, count: int) -> Written:
    """Allocate the output for N contacts."""
    zeros, size = storage.zeros, 3 * count
    jacobian, moved = zeros(2 * count, 3, 6), zeros(2 * count, 3, 6)
    return Written(zeros(size, 3), jacobian, moved, zeros(size, size), zeros(size))


def _stored(storage: Storage, system: System) -> System:
    """Return a system whose arrays live in a storage."""
    return System(*map(storage.array, system))


def _example(storage: Storage) -> tuple[Any, ...]:
    """Make two bodies that meet."""
    system = System(
        positions=np.eye(2, 3),
        velocities=np.eye(2, 3),
        spins=np.eye(2, 3),
        mobility=np.tile(np.eye(6), (2, 1, 1)),
        turns=np.ones(2, np.bool_),
        guides=np.zeros((0, 3)),
        pairs=np.array([[0, 1]]),
        points=np.zeros((1, 3)),
        normals=np.eye(1, 3),
    )
    return _stored(storage, system), storage.zeros(3), _room(storage, 1)


@entry(_example)
def write_contact_space(system: System, across: Array, written: Written) -> None:
    """
    Write the axes and velocities of contacts, and W.

    `across` (3,) is the normal of the plane of all motion; zero if the motion is not planar.
    """
    pairs, normals, velocities = system.pairs, system.normals, system.velocities
    axes, jacobian, moved, delassus, approach = written
    count = len(pairs)
    fastest = 0.0
    for b in range(len(velocities)):
        for k in range(3):
            fastest = max(fastest, abs(velocities[b][k]))
    for i in range(count):
        tangent = jacobian[2 * i][0]  # scratch: the tangent in the plane
        cross(across, normals[i], tangent)
        contact_axes(normals[i], tangent, tangent, axes, 3 * i)
        for side in range(2):
            b, row = pairs[i][side], 2 * i + side
            centre, sign = system.positions[b], 1.0 - 2.0 * side
            write_jacobian(sign, system.points[i], centre, axes, 3 * i, jacobian[row])
            multiply(jacobian[row], system.mobility[b], moved[row])
        for k in range(3):
            speed = 0.0
            for side in range(2):
                b, own = pairs[i][side], jacobian[2 * i + side][k]
                speed += dot(own, velocities[b])
                for m in range(3):
                    speed += own[3 + m] * system.spins[b][m]
            approach[3 * i + k] = speed if abs(speed) > rounding.SUM * fastest else 0.0
    for i in range(count):
        for j in range(i + 1):
            for side in range(2):
                for other in range(2):
                    if pairs[i][side] == pairs[j][other]:
                        add_block(
                            moved[2 * i + side], jacobian[2 * j + other], delassus, 3 * i, 3 * j
                        )
    for i in range(3 * count):
        for j in range(i):
            w = delassus[i][j]
            if abs(w) <= rounding.COUPLING * sqrt(delassus[i][i] * delassus[j][j]):
                w = 0.0
            delassus[i][j] = delassus[j][i] = w


@inner
def write_jacobian(
    sign: float, point: Array, centre: Array, axes: Floats, at: int, jacobian: Floats
) -> None:
    """Write the contact velocities (3, 6) per velocity and spin of a body, times a sign."""
    x, y, z = point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]
    for k in range(3):
        axis, row = axes[at + k], jacobian[k]
        for m in range(3):
            row[m] = sign * axis[m]
        row[3] = sign * (y * axis[2] - z * axis[1])
        row[4] = sign * (z * axis[0] - x * axis[2])
        row[5] = sign * (x * axis[1] - y * axis[0])


@inner
def multiply(jacobian: Floats, mobility: Floats, product: Floats) -> None:
    """Write the product of (3, 6) and (6, 6) floats."""
    for k in range(3):
        for column in range(6):
            product[k][column] = 0.0
        for m in range(6):
            factor = jacobian[k][m]
            if factor != 0.0:
                for column in range(6):
                    product[k][column] += factor * mobility[m][column]


@inner
def add_block(moved: Floats, jacobian: Floats, delassus: Floats, row: int, column: int) -> None:
    """Add the (3, 3) coupling of two contacts by a body that they share."""
    for k in range(3):
        for m in range(3):
            w = 0.0
            for part in range(6):
                w += moved[k][part] * jacobian[m][part]
            delassus[row + k][column + m] += w


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
    """Compute the contact space of a system."""
    run = write_contact_space.current()
    storage, across = run.storage, run.storage.array(_normal_of_plane(system))
    written = _room(storage, len(system.pairs))
    run(_stored(storage, system), across, written)
    return ContactSpace(
        np.asarray(written.axes).reshape(-1, 3, 3),
        np.asarray(written.delassus),
        np.asarray(written.approach),
    )


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
