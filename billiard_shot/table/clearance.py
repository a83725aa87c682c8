"""
Whether the cue has room: a stroke that would go through a ball or a cushion is refused.

The cue is a cone with the radius `ferrule_radius` at its tip and `BUTT` at its end. A cushion is
in its way where it passes below the line of noses; the frame behind is no higher.
"""

from math import hypot, inf, sqrt
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.compiled import inner
from billiard_shot.numerics import rounding
from billiard_shot.records import Storage, Vector
from billiard_shot.scene import Scene
from billiard_shot.status import CUE_THROUGH_BALL, CUE_THROUGH_CUSHION, OK

BUTT = 0.0145  # m: half of the 29 mm that most cues measure at their end
NOSES = 4  # at x > 0, x < 0, y > 0 and y < 0, as in NOSE_NAMES


class Surroundings(NamedTuple):
    """The cue, and what may be in its way. Lengths in m, frame `table`."""

    cue_length: float  # 0: nothing is in its way
    ferrule_radius: float
    ball_radius: float
    half_length: float  # of the rectangle of the noses; infinite without a table
    half_width: float
    nose_height: float
    balls: Any  # (balls, 2) floats: centres of the others

    def stored(self, storage: Storage) -> 'Surroundings':
        """Return them as compiled functions take them."""
        return self._replace(balls=storage.array(self.balls))


def nothing_around(ferrule_radius: float, ball_radius: float) -> Surroundings:
    """Make surroundings without obstacles, for a cue and a ball of these radii [m]."""
    return Surroundings(0.0, ferrule_radius, ball_radius, inf, inf, 0.0, balls=np.zeros((0, 2)))


def surroundings_of(scene: Scene) -> Surroundings:
    """Collect what may be in the way of the cue."""
    ferrule_radius, ball_radius = float(scene.cue.ferrule_radius), float(scene.ball.radius)
    if scene.cue.length == 0.0:
        return nothing_around(ferrule_radius, ball_radius)
    table = scene.table
    half_length, half_width, nose_height = inf, inf, 0.0
    if table is not None:
        half_length, half_width = 0.5 * float(table.length), 0.5 * float(table.width)
        nose_height = 2.0 * ball_radius * table.cushion.height
    return Surroundings(
        float(scene.cue.length),
        ferrule_radius,
        ball_radius,
        half_length,
        half_width,
        nose_height,
        balls=np.array(list(scene.object_balls.values()), float).reshape(-1, 2),
    )


@inner
def clearance(s: Surroundings, n: Vector, c: Vector, position: Vector) -> int:
    """Whether the cue of a stroke has room: OK, CUE_THROUGH_BALL or CUE_THROUGH_CUSHION."""
    if s.cue_length == 0.0:
        return OK
    for i in range(len(s.balls)):
        if depth_in_ball(s, i, n, c, position) > rounding.PLACE:
            return CUE_THROUGH_BALL
    for i in range(NOSES):
        if depth_in_cushion(s, i, n, c, position) > rounding.PLACE:
            return CUE_THROUGH_CUSHION
    return OK


@inner
def least_turn(s: Surroundings, n: Vector, c: Vector, position: Vector) -> float:
    """
    Find an angle by which a cue must at least be raised to have clearance [rad].

    A raised cue turns about the centre of the cue ball. So nothing comes out of it by more than
    this angle times its distance from there. Arguments as of `depth_in_ball`.
    """
    turn = 0.0
    for i in range(len(s.balls)):
        x, y = s.balls[i][0] - position[0], s.balls[i][1] - position[1]
        z = s.ball_radius - position[2]
        turn = max(turn, depth_in_ball(s, i, n, c, position) / sqrt(x * x + y * y + z * z))
    for i in range(NOSES):
        along = along_to_nose(s, i, n, c, position)
        if along >= 0.0:
            depth = depth_in_cushion(s, i, n, c, position) * hypot(c[0], c[1])
            turn = max(turn, depth / (along + s.ball_radius))
    return turn


@inner
def depth_in_ball(s: Surroundings, i: int, n: Vector, c: Vector, position: Vector) -> float:
    """
    How deep the cue would go into a ball [m]; negative if it has room.

    Parameters
    ----------
    s : Surroundings
    i : int
        The ball in `s.balls`.
    n, c : (3,) floats
        Where the tip meets the cue ball, and the direction of the stroke; unit vectors.
    position : (3,) floats
        Centre of the cue ball [m].

    """
    x = s.balls[i][0] - position[0] - s.ball_radius * n[0]
    y = s.balls[i][1] - position[1] - s.ball_radius * n[1]
    z = s.ball_radius - position[2] - s.ball_radius * n[2]
    along = -(x * c[0] + y * c[1] + z * c[2])
    if not along > 0.0:  # what reaches no farther back than the tip is in front of the cue
        return -inf
    along = min(along, s.cue_length)
    x, y, z = x + along * c[0], y + along * c[1], z + along * c[2]
    return s.ball_radius + thickness(s, along) - sqrt(x * x + y * y + z * z)


@inner
def depth_in_cushion(s: Surroundings, i: int, n: Vector, c: Vector, position: Vector) -> float:
    """How deep the cue would go into a cushion [m]; arguments as of `depth_in_ball`."""
    along = along_to_nose(s, i, n, c, position)
    if along < 0.0:
        return -inf
    height = position[2] + s.ball_radius * n[2] - along * c[2]
    return s.nose_height - height + thickness(s, along) / hypot(c[0], c[1])


@inner
def along_to_nose(s: Surroundings, i: int, n: Vector, c: Vector, position: Vector) -> float:
    """How far behind its tip a cue is above a nose, or below it [m]; -inf: nowhere."""
    axis, sign = i // 2, 1.0 - 2.0 * (i % 2)
    half = s.half_length if axis == 0 else s.half_width
    toward = -sign * c[axis]
    if toward == 0.0:
        return -inf
    along = (half - sign * (position[axis] + s.ball_radius * n[axis])) / toward
    return along if 0.0 <= along <= s.cue_length else -inf


@inner
def thickness(s: Surroundings, along: float) -> float:
    """Half of the thickness of the cue so far behind its tip [m]."""
    return s.ferrule_radius + (BUTT - s.ferrule_radius) * along / s.cue_length
