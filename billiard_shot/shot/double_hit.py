"""
Whether the cue, after its strike, catches the ball again: a double hit, a foul in most games.

The cue goes on along its line with the speed that the strike left it, as far as players follow
through, while the ball does what the prediction says: it may have met another ball close in front,
or come back with draw or from a cushion. That is found, not simulated: what the cue does between
depends on the hand that holds it.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.table.trajectory import Trajectory

FOLLOW = 0.15  # m
LONGEST = 1.0  # s: nobody follows through for longer, however slowly
STEP = 2e-4  # s
DEEP = 1e-5  # m: what is less is no gap, and no hit


def first_double_hit(
    trajectory: Trajectory,
    radius: float,
    tip: NDArray[np.float64],
    direction: NDArray[np.float64],
    speed: float,
) -> float | None:
    """
    Time [s] from the end of the strike until the ball is at the cue again, None if it never is.

    Parameters
    ----------
    trajectory : Trajectory
        Of the struck ball.
    radius : float
        Of the ball [m].
    tip : (3,) float array
        Where the tip is at the end of the strike [m].
    direction : (3,) float array
        Unit vector of the stroke.
    speed : float
        Of the cue along it [m/s].

    """
    if speed <= 0.0:
        return None
    times = np.arange(1, 2 + int(min(FOLLOW / speed, LONGEST) / STEP)) * STEP
    from_tip = trajectory.at(times).position - tip - np.outer(speed * times, direction)
    along = np.minimum(from_tip @ direction, 0.0)  # behind the tip there is the cue
    gap = np.linalg.norm(from_tip - np.outer(along, direction), axis=1) - radius
    # At first they are in touch; the end of the cue, which gave way, needs a moment to swing back.
    parted = np.logical_or.accumulate(gap > DEEP)
    met = np.flatnonzero(parted & (gap < -DEEP))
    return float(times[met[0]]) if len(met) else None
