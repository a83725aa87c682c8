"""
Balls without friction whose contacts are springs, in small steps of equal length.

Independent of billiard_shot: every pair of balls is looked at in every step, and its normal is
that of the moment. A contact has a compression y, with y' = -u_n, divided by e^2 while the balls
part, and the force k y^p (Liu, Zhao, Brogliato, Proc. R. Soc. A 464, 2008: bistiffness). An open
contact closes at the distance at which it ended last.
"""

from math import gamma, pi, sqrt
from typing import NamedTuple

import numpy as np


class State(NamedTuple):
    """Positions and velocities (B, 3) of balls, and whether any contact is closed."""

    positions: np.ndarray
    velocities: np.ndarray
    closed: bool


def spring(mass, duration, exponent, speed=3.0):
    """Stiffness of balls whose contact has a duration [s] if they meet at a speed [m/s]."""
    # Energy m v^2 / 4 = k y^(p + 1) / (p + 1), T v / y = 2 integral of dx / sqrt(1 - x^(p + 1)).
    share = 1.0 / (exponent + 1.0)
    depth = speed * duration / (2.0 * sqrt(pi) * gamma(1.0 + share) / gamma(0.5 + share))
    return 0.25 * (exponent + 1.0) * mass * speed**2 / depth ** (exponent + 1.0)


def collide(positions, velocities, balls, times, step=1e-6):
    """
    Return the states at some times.

    Leapfrog: half a step of the positions, a step of compressions and velocities, half a step of
    the positions.

    Parameters
    ----------
    positions, velocities : (B, 3) float arrays
    balls : radius [m], mass [kg], restitution, stiffness [N/m^exponent], exponent
    times : float array
        Ascending [s].
    step : float
        [s]

    Returns
    -------
    list of State

    """
    radius, mass, restitution, stiffness, exponent = balls
    x, v = np.array(positions, float), np.array(velocities, float)
    first, second = np.triu_indices(len(x), 1)
    pairs = np.arange(len(first))
    signs = np.zeros((len(x), len(first)))
    signs[first, pairs], signs[second, pairs] = 1.0 / mass, -1.0 / mass
    closing = np.full(len(first), 2.0 * radius)  # distance at which a contact closes
    y, closed = np.zeros(len(first)), np.zeros(len(first), bool)
    found, steps = [], np.rint(np.asarray(times) / step).astype(int)
    for number in range(1, steps[-1] + 1):
        x += 0.5 * step * v
        apart = x[first] - x[second]
        distances = np.sqrt(np.einsum('ij,ij->i', apart, apart))
        normals = apart / distances[:, np.newaxis]
        opening = np.einsum('ij,ij->i', normals, v[first] - v[second])
        rate = np.where(opening < 0.0, 1.0, 1.0 / restitution**2)
        y = np.where(closed, y - step * rate * opening, closing - distances)
        closing = np.where(closed & (y <= 0.0), distances, closing)
        closed = y > 0.0
        force = np.where(closed, stiffness * np.maximum(y, 0.0) ** exponent, 0.0)
        v += step * signs @ (force[:, np.newaxis] * normals)
        x += 0.5 * step * v
        if number in steps:
            found.append(State(x.copy(), v.copy(), bool(closed.any())))
    return found
