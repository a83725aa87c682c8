"""
Orientations of balls, from their spin.

On a segment the spin is linear in time, w0 + w' t, about an axis that may turn. A step of length h
turns the ball by the vector
    h w(h/2) + h^3/12 w' x w0 ,
the Magnus series (Iserles et al., Acta Numerica 2000, section 4) to fourth order.
"""

import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.table.trajectory import Trajectory

MAX_TURN = 0.35  # rad by which a ball turns from one orientation to the next, at most
Quaternion = NDArray[np.float64]  # (4,) x y z w, of length 1


def orientations(
    ball: Trajectory, until: float, first: Quaternion
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """
    Follow a ball's orientation.

    Parameters
    ----------
    ball : Trajectory
    until : float
        Time to which it is followed [s].
    first : (4,) float array
        Orientation at time 0: x y z w, from the ball's frame to the table's.

    Returns
    -------
    times, quaternions : (n,) and (n, 4) float arrays
        In order; between two of them the ball turns by at most `MAX_TURN`.

    """
    times, found = [0.0], [first]
    for segment in ball.segments:
        end = min(segment.end, until)
        duration = end - segment.start
        if duration <= 0.0 or not math.isfinite(duration):
            continue
        w, change = segment.spin, segment.angular_acceleration
        fastest = max(np.linalg.norm(w), np.linalg.norm(w + change * duration))
        steps = max(1, math.ceil(fastest * duration / MAX_TURN))
        h = duration / steps
        twist = h**3 / 12.0 * np.cross(change, w)
        for step in range(steps):
            turn = h * (w + change * (step + 0.5) * h) + twist
            found.append(product(rotation(turn), found[-1]))
            times.append(segment.start + (step + 1) * h)
    return np.array(times), np.array(found)


def rotation(vector: NDArray[np.float64]) -> Quaternion:
    """Turn about a vector by its length [rad], as a quaternion."""
    angle = float(np.linalg.norm(vector))
    part = 0.5 * np.sinc(0.5 * angle / math.pi)  # sin(angle / 2) / angle
    return np.append(part * vector, math.cos(0.5 * angle))


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Turn by b, then by a."""
    return np.append(
        a[3] * b[:3] + b[3] * a[:3] + np.cross(a[:3], b[:3]), a[3] * b[3] - a[:3] @ b[:3]
    )
