"""The agent `random`: any stroke. It shows what a game makes of moves without sense."""

import math

import numpy as np

from billiard_shot.game.state import Call, Decision, Ruling, State
from billiard_shot.game.strokes import places_to_try
from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run.results import POCKET_NAMES

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
        self._scene, self._draw = scene, np.random.default_rng(seed)

    def place(self, state: State) -> tuple[float, float]:
        """Place the cue ball at any allowed place."""
        x, y = self._draw.choice(places_to_try(state)).tolist()
        return x, y

    def decide(self, state: State) -> Decision:
        """Take any choice, or play any stroke and call any ball."""
        draw = self._draw
        if state.choices:
            return Decision(choice=str(draw.choice(state.choices)))
        robot = self._scene.robot
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


make = RandomAgent
