"""Interpolation of trajectories as joint_trajectory_controller of ros2_control does it."""

import numpy as np

POWERS = np.arange(6)


def quintic(trajectory, time):
    """
    Position, velocity and acceleration (n,) at a time [s] within a trajectory.

    A quintic polynomial between knots has position, velocity and acceleration of both knots
    (control.ros.org, "Trajectory Representation").
    """
    i = np.searchsorted(trajectory.times, time, side='right') - 1
    i = min(max(i, 0), len(trajectory.times) - 2)
    span, t = trajectory.times[i + 1] - trajectory.times[i], time - trajectory.times[i]
    rows = [
        (trajectory.positions[k], trajectory.velocities[k], trajectory.accelerations[k])
        for k in (i, i + 1)
    ]
    # In the unit of the span: otherwise short spans give large rounding errors.
    scales = (1.0, span, span**2)
    system = np.array([_row(at, order) for at in (0.0, 1.0) for order in range(3)])
    ends = np.array(
        [scale * row for side in rows for scale, row in zip(scales, side, strict=True)]
    )
    coefficients = np.linalg.solve(system, np.array(ends))
    return tuple(_row(t / span, order) @ coefficients / scales[order] for order in range(3))


def _row(x, order):
    factor = np.ones(6)
    for k in range(order):
        factor = factor * (POWERS - k)
    return factor * x ** np.maximum(POWERS - order, 0)
