"""Balls on their way, for the tests of this folder."""
import numpy as np

from billiard_shot.compiled import entry
from billiard_shot.status import Status
from billiard_shot.table import motion
from billiard_shot.table.roll_out import roll_out
from billiard_shot.table.surface import Surface
from billiard_shot.table.trajectory import Trajectory

POOL = Surface(
    mass=0.17, radius=0.028, inertia=0.4 * 0.17 * 0.028**2, gravity=9.8, sliding=0.2,
    rolling=0.01, spin_deceleration=10.0, restitution=0.5, friction=0.2, stiffness=1.0,
    law=0, exponent=1.0, flight=0,
)


@entry
def roll(surface, position, velocity, spin, tolerance, segments):
    ball = motion.start(position, velocity, spin)
    status, error = roll_out(surface, ball, tolerance, segments)
    return status, error, int(ball[motion.COUNT])


def run(velocity, spin=(0, 0, 0), surface=POOL, tolerance=1e-6, rows=200):
    """Trajectory, status and error of a ball that starts at the origin."""
    segments = np.full((rows, motion.COLUMNS), np.nan)
    status, error, count = roll(
        surface, np.array([0.0, 0.0, surface.radius]), np.array(velocity, float),
        np.array(spin, float), tolerance, segments,
    )
    return Trajectory(segments[:count]), Status(status), error
