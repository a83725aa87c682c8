"""How the place of rest depends on the stroke, by differences."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.play import play_many, Strokes
from billiard_shot.shot.stroke import Stroke, stroke_at
from billiard_shot.status import Status

STEP = 1e-4  # in radii, radians and parts of the speed
TOLERANCE = 1e-9  # m


def sensitivity_of(
    scene: Scene, stroke: Stroke, position: NDArray[np.float64]
) -> NDArray[np.float64]:
    """
    Find the derivative of the place of rest by (a, b, elevation, azimuth, speed), (2, 5).

    (a, b) is where the tip touches the ball.

    The stroke is one that can be played. Central differences; one-sided where only one of the two
    neighbours can be played, and zero where neither can. `position` is the ball's [m].
    """
    model = model_of(scene)
    base = np.array(stroke.touching(model.tip_curvature).offsets)
    steps = np.full(5, STEP)
    steps[4] *= base[4]
    changes = np.vstack([np.zeros(5), np.diag(steps), -np.diag(steps)])
    near = [stroke_at(*(base + change)) for change in changes]
    normals, velocities = np.array([s.normal for s in near]), np.array([s.velocity for s in near])
    strokes = Strokes(scene, model, normals, velocities, position)
    strikes = play_many(strokes, TOLERANCE)[0].strikes
    played, ends = strikes['status'] < Status.MISS, strikes['final_position']
    rest = np.where(played[:, np.newaxis], ends, ends[0])[:, :2]
    reach = np.where(played, np.concatenate([[0.0], steps, -steps]), 0.0)
    span = reach[1:6] - reach[6:]
    return ((rest[1:6] - rest[6:]) / np.where(span > 0.0, span, 1.0)[:, np.newaxis]).T
