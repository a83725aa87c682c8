"""From one motion of a ball to its next: what it does now, until when, and what that ends in."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.cloth import lie, settle
from billiard_shot.table.flight import bounce, take_off
from billiard_shot.table.motion import (
    ACCELERATION,
    advance,
    ANGULAR_ACCELERATION,
    CAUSE,
    END,
    FALL,
    FLIGHT,
    MOTION,
    OWN,
    SPIN_ENDS,
)
from billiard_shot.table.surface import Surface


@fused
def begin(surface: Surface, ball: NDArray[np.float64], tolerance: float) -> float:
    """
    Find what a ball does from now on: motion, accelerations, end. Return the error made [m].

    `tolerance` [m] is for leaving out small bounces.
    """
    for i in range(3):
        ball[ACCELERATION + i] = 0.0
        ball[ANGULAR_ACCELERATION + i] = 0.0
    ball[SPIN_ENDS] = 0.0
    ball[FALL] = 0.0
    flies, error = take_off(surface, ball, tolerance)
    if not flies:
        lie(surface, ball)
    return error


@fused
def finish(surface: Surface, ball: NDArray[np.float64]) -> None:
    """Follow a ball's motion to its end, and make the change that ends it."""
    advance(ball, ball[END])
    if ball[MOTION] == FLIGHT:
        bounce(surface, ball)
    else:
        settle(surface, ball)
    ball[CAUSE] = OWN
