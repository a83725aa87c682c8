"""The agent `random`: any stroke. It shows what a game makes of moves without sense."""

import math

import numpy as np

from billiard_shot.game.call import Call, Decision
from billiard_shot.game.ruling import Ruling
from billiard_shot.game.state import State
from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run import POCKET_NAMES

STEEP = math.radians(12.0)  # high enough to clear the cushions and most balls behind the cue ball


class RandomAgent:
    """
    Plays with random places, directions and speeds.

    Parameters
    ----------
    scene : Scene
        Its `robot` limits the speed.
    seed : int

    """

    def __init__(self, scene: Scene, seed: int) -> None:
        self._robot, self._draw = scene.robot, np.random.default_rng(seed)

    def place(self, state: State) -> tuple[float, float]:
        """Place the cue ball at any allowed place."""
        return random_place(state, self._draw)

    def decide(self, state: State) -> Decision:
        """Take any choice, or play any stroke and call any ball."""
        draw = self._draw
        if state.choices:
            return Decision(choice=str(draw.choice(state.choices)))
        robot = self._robot
        azimuth = math.radians(
            robot.azimuth_deg + robot.azimuth_half_range_deg * draw.uniform(-1, 1)
        )
        speed = draw.uniform(robot.speed_min, robot.speed_max)
        elevation = min(
            max(STEEP, math.radians(robot.elevation_min_deg)),
            math.radians(robot.elevation_max_deg),
        )
        call = Call(
            ball=str(draw.choice(state.object_balls)), pocket=str(draw.choice(POCKET_NAMES))
        )
        return Decision(Stroke.from_offsets(0.0, 0.0, elevation, azimuth, speed), call)

    def saw(self, state: State, decision: Decision, ruling: Ruling) -> None:
        """Learn nothing."""


def random_place(state: State, draw: np.random.Generator) -> tuple[float, float]:
    """Draw a place where the cue ball may be placed [m]."""
    half = np.array([state.length, state.width]) / 2.0 - state.radius
    while True:
        x, y = (half * draw.uniform(-1.0, 1.0, 2)).tolist()
        if state.in_hand == 'kitchen':
            x = -half[0] + (half[0] - 0.25 * state.length) * draw.uniform()
        if not state.no_place(x, y):
            return float(x), float(y)


make = RandomAgent
