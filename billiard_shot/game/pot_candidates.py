"""Candidates for potting strokes: direct shots at several speeds, heights and sides of the tip."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.game.clearance import raised
from billiard_shot.planning.shots import DirectShots
from billiard_shot.planning.strikes import unit_speed_strikes
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.shot.effects import model_of

SPEED_FACTORS = 0.75, 1.0, 1.4, 2.0  # relative to the speed of the direct shot
# a and b, relative to the largest offset of the robot: stun, draw and follow, and side spin
TIP_OFFSETS = (
    (0.0, 0.0),
    (0.0, 0.4),
    (0.0, 0.8),
    (0.0, -0.4),
    (0.0, -0.8),
    (0.5, 0.0),
    (-0.5, 0.0),
    (0.5, 0.5),
    (-0.5, 0.5),
)
# Changes of the direction of the ball [rad] that are tried for each stroke, because of throw.
AIM_CHANGES = np.radians([-3.0, -1.5, 0.0, 1.5, 3.0])


class PotCandidates(NamedTuple):
    """
    Strokes that may pot a ball.

    Attributes
    ----------
    offsets : (n, turns, 5) float array
        Each stroke, aimed in several directions.
    shot : (n,) int array
        The direct shot from which it was made.

    """

    offsets: Array
    shot: NDArray[np.int64]


def pot_candidates(
    scene: Scene, direct: DirectShots, which: NDArray[np.int64], *, tips: int = len(TIP_OFFSETS)
) -> PotCandidates:
    """
    Make strokes of several speeds and spins of direct shots on one table.

    Parameters
    ----------
    scene : Scene
        With the balls as they lie.
    direct : DirectShots
        Of that table.
    which : (k,) int array
        The shots to begin with.
    tips : int
        How many points of contact of the tip are tried.

    """
    robot = scene.robot
    grid = np.array([(a, b, factor) for a, b in TIP_OFFSETS[:tips] for factor in SPEED_FACTORS])
    shot = np.repeat(which, len(grid))
    offsets = direct.offsets[shot].copy()
    a, b, factor = np.tile(grid, (len(which), 1)).T
    offsets[:, 0], offsets[:, 1] = robot.offset_max * a, robot.offset_max * b
    offsets[:, 4] *= factor
    offsets, playable = raised(scene, offsets)
    offsets, shot = offsets[playable], shot[playable]
    # The direction in which the ball starts, relative to the azimuth, does not depend on it.
    tips_used, number = np.unique(offsets[:, :3].round(6), axis=0, return_inverse=True)
    motion = unit_speed_strikes(scene, model_of(scene), tips_used)[number.ravel()]
    offsets[:, 3] -= np.nan_to_num(np.arctan2(motion[:, 1], motion[:, 0]))
    turn = 2.0 * scene.ball.radius * np.cos(direct.cut[shot]) / direct.distance[shot]
    many = np.repeat(offsets[:, np.newaxis], len(AIM_CHANGES), axis=1)
    many[:, :, 3] += turn[:, np.newaxis] * AIM_CHANGES
    return PotCandidates(many, shot)
