"""The resting place of a ball after a strike, for the studies."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.table.simulate import simulate
from billiard_shot.table.trajectory import BallState

BOUNCE_TOLERANCE = 1e-13  # m, for leaving out bounces


def resting_place(
    scene: Scene, velocity: NDArray[np.float64], spin: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the place (3,) [m] at which a ball from (0, 0, r) rests on an endless cloth."""
    start = np.array([0.0, 0.0, scene.ball.radius])
    ball = BallState(position=start, velocity=velocity, spin=spin)
    return simulate(
        replace(scene, table=None), {'cue': ball}, tolerance=BOUNCE_TOLERANCE
    ).final_position['cue']
