"""All that a ball does on an empty, unbounded table, from one state to rest."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.status import Status
from billiard_shot.table.cloth import come_to_rest
from billiard_shot.table.flight import fly
from billiard_shot.table.surface import Surface

OK = int(Status.OK)
NEVER_RESTS = int(Status.NEVER_RESTS)


@compiled
def roll_out(
    surface: Surface,
    row: NDArray[np.float64],
    tolerance: float,
    accuracy: float,
    segments: NDArray[np.float64],
) -> tuple[int, int, int, float]:
    """
    Follow a ball until it rests.

    Parameters
    ----------
    surface : Surface
    row : (COLUMNS,) float array, changed
        The ball's state, see motion.py; in the end the one in which it rests or, where it never
        does, the one in which its last, endless motion began.
    tolerance : float
        For leaving out small bounces [m].
    accuracy : float
        Of each bounce, relative to the ball's speed.
    segments : (rows, COLUMNS) float array, written
        The motion, as far as there is room.

    Returns
    -------
    status, count, hops, error : int, int, int, float
        OK, NEVER_RESTS or BUDGET_EXCEEDED; the number of segments, and of those spent in the air;
        the bound of the error made by leaving out bounces [m].

    """
    hops, error, status = fly(surface, row, tolerance, accuracy, segments)
    if status != OK:
        return status, hops, hops, error
    count, ends = come_to_rest(surface, row, segments, hops)
    return OK if ends else NEVER_RESTS, count, hops, error
