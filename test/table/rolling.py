"""Balls on their way, for the tests of this folder."""

from billiard_shot.records import as_rows, OBJECTS
from billiard_shot.status import Status
from billiard_shot.table.motion import Ball, Segment, start_ball
from billiard_shot.table.params import BallClothParams
from billiard_shot.table.roll_out import roll_out
from billiard_shot.table.trajectory import Trajectory

POOL = BallClothParams(
    mass=0.17,
    radius=0.028,
    inertia=0.4 * 0.17 * 0.028**2,
    gravity=9.8,
    sliding_friction=0.2,
    rolling_resistance=0.01,
    spin_deceleration=10.0,
    cloth_restitution=0.5,
    cloth_friction=0.2,
    cloth_stiffness=1.0,
    law=0,
    exponent=1.0,
    flight_gate=0,
)


def run(velocity, spin=(0, 0, 0), params=POOL, tolerance=1e-6, rows=200):
    """Trajectory, status and error of a ball that starts at the origin."""
    ball, segments = Ball(), OBJECTS.records(Segment, rows)
    start_ball(ball, [0.0, 0.0, params.radius], list(map(float, velocity)), list(map(float, spin)))
    status, error, _ = roll_out(params, ball, tolerance, segments, Ball(), 0.0)
    return Trajectory(as_rows(Segment, segments[: ball.segments])), Status(status), error
