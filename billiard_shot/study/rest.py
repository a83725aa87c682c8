"""Where a ball comes to rest after a strike, for the studies."""
import numpy as np

from billiard_shot.shot.model import Model
from billiard_shot.study.problem import Vector
from billiard_shot.table import motion
from billiard_shot.table.roll_out import roll_out

FINE = 1e-13  # m for leaving out bounces, and the accuracy of each


def place_of_rest(model: Model, velocity: Vector, spin: Vector) -> Vector:
    """Place (3,) [m] at which a ball from (0, 0, r) rests."""
    ball = motion.start(np.array([0.0, 0.0, model.surface.radius]), velocity, spin)
    nothing = np.empty((0, motion.COLUMNS))
    getattr(roll_out, 'py_func', roll_out)(model.surface, ball, FINE, FINE, nothing)
    return ball[motion.POSITION : motion.POSITION + 3]
