"""Whether a strike sits on a jump of its law: two outcomes, however accurately it is solved."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot import row as at
from billiard_shot.shot.accuracy import inner_tolerance
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.many import shoot_rows
from billiard_shot.shot.model import TIP
from billiard_shot.shot.stroke import Stroke

CLOSE = 10.0  # accuracies of the strike, relative to the stiffness: near enough to be on a jump
COARSEST = 1e-6  # accuracy of a strike


def jump_of(
    scene: Scene, stroke: Stroke, position: NDArray[np.float64], tolerance: float
) -> float:
    """
    How far the place of rest on an endless cloth jumps [m], 0 where it is continuous.

    The strike is solved again with the tip a little stiffer and a little softer, by as much as
    its accuracy is. The changes of a smooth outcome cancel; what is left of a larger size than the
    tolerance is a jump in between. `position` is the ball's [m].
    """
    model = model_of(scene)
    normal, velocity = np.array([stroke.normal]), np.array([stroke.velocity])
    change = CLOSE * min(inner_tolerance(model, stroke.speed, tolerance), COARSEST)
    rests = []
    for factor in (1.0 - change, 1.0, 1.0 + change):
        stiffness = model.stiffness.copy()
        stiffness[TIP] *= factor
        changed = model._replace(stiffness=stiffness)
        row, = shoot_rows(changed, normal, velocity, position, tolerance)
        rests.append(row[at.REST])
    bend = float(np.linalg.norm(rests[0] - 2.0 * rests[1] + rests[2]))
    return bend if bend > 2.0 * tolerance else 0.0
