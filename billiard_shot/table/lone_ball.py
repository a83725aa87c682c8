"""The record of a table on which only one ball moves, from that ball's trajectory."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import ROWS
from billiard_shot.scene import Ball
from billiard_shot.status import Status
from billiard_shot.table.motion import Cause, NOTHING, Segment
from billiard_shot.table.run import EventLog, TableRun
from billiard_shot.table.simulation_state import Event
from billiard_shot.table.trajectory import Trajectory


def run_of_lone_ball(
    name: str,
    trajectory: Trajectory,
    resting: Mapping[str, tuple[float, float]],
    ball: Ball,
    status: Status,
) -> TableRun:
    """
    Make the record of a table, as `simulate` makes it, if one ball moves and meets no other.

    Parameters
    ----------
    name, trajectory
        Of the ball that moves.
    resting : mapping of str to (x, y)
        The other balls [m].
    ball : Ball
        Mass, radius and inertia of every ball.
    status : Status

    """
    rest = ROWS.records(Segment, len(resting))
    rest['ball'] = np.arange(1, 1 + len(resting))
    rest['position'] = [(x, y, ball.radius) for x, y in resting.values()] or np.zeros((0, 3))
    return TableRun(
        (name, *resting),
        status,
        trajectory.duration,
        0.0,
        0,
        np.concatenate([trajectory.rows, rest]),
        EventLog(_events(trajectory, ball), np.zeros((0, 2), np.int64)),
        np.full((1 + len(resting), 2), NOTHING),
    )


def _events(trajectory: Trajectory, ball: Ball) -> NDArray[np.void]:
    before, after = trajectory.rows[:-1], trajectory.rows[1:]
    log: NDArray[np.void] = ROWS.records(Event, len(after))
    log['time'], log['cause'], log['other'] = after['time'], after['cause'], NOTHING
    log['motion_before'], log['motion_after'] = before['motion'], after['motion']
    dt = (after['time'] - before['time'])[:, np.newaxis]
    log['energy_before'] = _energy(
        ball,
        before['velocity'] + before['acceleration'] * dt,
        before['spin'] + before['spin_acceleration'] * dt,
    )
    log['energy_after'] = _energy(ball, after['velocity'], after['spin'])
    return log[after['cause'] != Cause.RELEASE]


def _energy(
    ball: Ball, velocity: NDArray[np.float64], spin: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Kinetic energy (n,) [J]."""
    energy: NDArray[np.float64] = 0.5 * (
        ball.mass * (velocity**2).sum(axis=1) + ball.inertia * (spin**2).sum(axis=1)
    )
    return energy
