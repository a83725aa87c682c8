"""The beginning of a trajectory, ended by a brake: it is safe if nothing follows it."""

import numpy as np

from billiard_shot.cue.joint_trajectory import JointTrajectory
from billiard_shot.records import Array

MIN_BRAKE_TIME = 0.02
"""Shortest brake [s]; a controller should receive no points that are closer together."""

PEAK = 1.5
"""Largest deceleration of `braked`, relative to the mean deceleration."""


def excerpt(trajectory: JointTrajectory, end: float, accelerations: Array) -> JointTrajectory:
    """
    Follow a trajectory until the time `end` [s], and then brake.

    Parameters
    ----------
    trajectory : JointTrajectory
    end : float
    accelerations : (n,) float array
        Largest decelerations in the brake [m/s^2, rad/s^2].

    Returns
    -------
    JointTrajectory
        The whole trajectory if it ends earlier. The brake takes quintic interpolation, as the
        joint_trajectory_controller of ros2_control has it: its velocity is a cubic polynomial.

    """
    if end >= trajectory.duration:
        return trajectory
    position, velocity, acceleration = trajectory.at(end)
    time, target = braked(position, velocity, acceleration, accelerations)
    kept = trajectory.times < end
    still = np.zeros_like(target)

    def rows(before: Array, at_end: Array, after: Array) -> Array:
        return np.vstack([before[kept], at_end, after])

    return JointTrajectory(
        np.append(trajectory.times[kept], (end, end + time)),
        rows(trajectory.positions, position, target),
        rows(trajectory.velocities, velocity, still),
        rows(trajectory.accelerations, acceleration, still),
    )


def braked(
    position: Array, velocity: Array, acceleration: Array, limits: Array
) -> tuple[float, Array]:
    """
    Find the time [s] in which joints (n,) come to rest, and where.

    The velocity falls as a cubic polynomial, with the given `acceleration` at its beginning.
    """
    time = max(float((PEAK * np.abs(velocity) / limits).max()), MIN_BRAKE_TIME)
    return time, position + velocity * time / 2.0 + acceleration * time**2 / 12.0
