"""All that a ball does on an empty, unbounded table, from one state to rest."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.status import Status
from billiard_shot.table.motion import END, FLIGHT, MOTION, record, REST
from billiard_shot.table.steps import begin, finish
from billiard_shot.table.surface import Surface

OK = int(Status.OK)
NEVER_RESTS = int(Status.NEVER_RESTS)
BUDGET_EXCEEDED = int(Status.BUDGET_EXCEEDED)


@fused
def ending(surface: Surface, ball: NDArray[np.float64]) -> int:
    """Status of a ball in its last motion: OK, NEVER_RESTS or BUDGET_EXCEEDED."""
    if ball[MOTION] == FLIGHT and surface.restitution < 1.0:
        return BUDGET_EXCEEDED
    return OK if ball[MOTION] == REST or ball[MOTION] > FLIGHT else NEVER_RESTS


@fused
def roll_out(
    surface: Surface, ball: NDArray[np.float64], tolerance: float, segments: NDArray[np.float64]
) -> tuple[int, float]:
    """
    Follow a ball until it rests.

    Parameters
    ----------
    surface : Surface
    ball : (STATE,) float array, changed
        The ball, see motion.py. In the end its state at rest or, where it never rests, where its
        last, endless motion begins.
    tolerance : float
        For leaving out small bounces [m].
    segments : (n, COLUMNS) float array, written
        The motion, as far as there is room.

    Returns
    -------
    status, error : int, float
        OK, NEVER_RESTS or BUDGET_EXCEEDED; the bound of the error made by leaving out bounces [m].

    """
    error = begin(surface, ball, tolerance)
    record(ball, segments)
    while ball[END] < np.inf:
        finish(surface, ball)
        error = max(error, begin(surface, ball, tolerance))
        record(ball, segments)
    return ending(surface, ball), error
