"""Balls on their way, for the tests of this folder."""

from billiard_shot.status import Status
from billiard_shot.table.model.geometry import BallClothParams
from billiard_shot.table.run.layout import ENDLESS
from billiard_shot.table.run.results import Trajectory
from billiard_shot.table.run.states import ball_starts
from billiard_shot.table.run.task import run_with_events, TableTask

CLOTH = BallClothParams(
    mass=0.17,
    radius=0.028,
    inertia=0.4 * 0.17 * 0.028**2,
    gravity=9.8,
    sliding_friction=0.2,
    rolling_resistance=0.01,
    rolling_rise=0.0,
    spin_deceleration=10.0,
    cloth_restitution=0.5,
    cloth_friction=0.2,
    law=0,
    exponent=1.0,
    flight_gate=0,
)


def run(velocity, spin=(0, 0, 0), params=CLOTH, tolerance=1e-6):
    """Trajectory, status and error of a ball that starts at the origin."""
    starts = ball_starts(1, 1)
    starts['position'], starts['velocity'] = (0.0, 0.0, params.radius), velocity
    starts['spin'] = spin
    ran = run_with_events(TableTask(params, ENDLESS, starts, tolerance))
    status = Status(int(ran.tables['status'][0]))
    return Trajectory(ran.segments), status, float(ran.balls['left_out'][0, 0])
