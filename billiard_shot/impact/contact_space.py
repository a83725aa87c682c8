"""From bodies to contact space: velocities at the contacts, and how impulses change them."""

from collections.abc import Sequence

import numpy as np

from billiard_shot.impact.bodies import Body, Contact, Vector
from billiard_shot.numerics import rounding
from billiard_shot.numerics.frames import contact_axes


def frames(bodies: Sequence[Body], contacts: Sequence[Contact]) -> Vector:
    """
    Axes of all contacts as rows, (N, 3, 3): the normal and two tangents.

    Where all that happens stays in one plane, the second tangents are normal to it, and nothing
    couples to them. Otherwise any tangents do.
    """
    seen = [np.asarray(contact.normal) for contact in contacts]
    for contact in contacts:
        for index in (contact.a, contact.b):
            body = bodies[index]
            lever = np.asarray(contact.point) - np.asarray(body.position)
            seen += [] if body.inertia is None else [lever, np.cross(np.asarray(body.spin), lever)]
            seen += [np.asarray(body.velocity)]
            seen += [] if body.guide is None else [np.asarray(body.guide)]
    units = [v / np.linalg.norm(v) for v in seen if np.linalg.norm(v) > 0.0]
    _, spread, axes = np.linalg.svd(np.array(units))
    across = axes[2] if len(spread) < 3 or spread[2] < 1e-12 * spread[0] else np.zeros(3)
    rows = np.zeros((3 * len(contacts), 3)).tolist()
    for i, contact in enumerate(contacts):
        normal = np.asarray(contact.normal, float)
        in_plane = np.cross(across, normal).tolist()
        contact_axes(normal.tolist(), in_plane, in_plane, rows, 3 * i)
    return np.array(rows).reshape(-1, 3, 3)


def jacobians(bodies: Sequence[Body], contacts: Sequence[Contact], axes: Vector) -> Vector:
    """Contact velocities per velocity and spin of each body: (bodies, 3 N, 6)."""
    result = np.zeros((len(bodies), 3 * len(contacts), 6))
    for i, contact in enumerate(contacts):
        for index, sign in ((contact.a, 1.0), (contact.b, -1.0)):
            lever = np.asarray(contact.point) - np.asarray(bodies[index].position)
            rows = result[index, 3 * i : 3 * i + 3]
            rows[:, :3] = sign * axes[i]
            rows[:, 3:] = sign * np.cross(lever, axes[i])
    return result


def response(jacobian: Vector, mobility: Vector) -> Vector:
    """
    W (3 N, 3 N) [1/kg]: the contact velocities that unit contact impulses cause.

    W is symmetric, and couplings that are only rounding are made exactly zero.
    """
    w: Vector = np.einsum('bik,bkl,bjl->ij', jacobian, mobility, jacobian)
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
