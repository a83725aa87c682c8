"""All that a ball does on an empty, unbounded table, from one state to rest."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import inlined
from billiard_shot.impact.kernel import solve
from billiard_shot.status import Status
from billiard_shot.table.cloth import come_to_rest, slip_of
from billiard_shot.table.flight import CLIMB, ENDLESS, fly, LIES, PAUSED, push, response_of
from billiard_shot.table.surface import Surface

OK = int(Status.OK)
NEVER_RESTS = int(Status.NEVER_RESTS)
BUDGET_EXCEEDED = int(Status.BUDGET_EXCEEDED)


@inlined
def roll_out(
    surface: Surface,
    ball: NDArray[np.float64],
    tolerance: float,
    accuracy: float,
    segments: NDArray[np.float64],
) -> tuple[int, float]:
    """
    Follow a ball until it rests.

    Parameters
    ----------
    surface : Surface
    ball : (COLUMNS + 1,) float array, changed
        The ball, see motion.py. In the end its state at rest or, where it never rests, where its
        last, endless motion begins.
    tolerance : float
        For leaving out small bounces [m].
    accuracy : float
        Of each bounce, relative to the ball's speed.
    segments : (n, COLUMNS) float array, written
        The motion, as far as there is room.

    Returns
    -------
    status, error : int, float
        OK, NEVER_RESTS or BUDGET_EXCEEDED; the bound of the error made by leaving out bounces [m].

    """
    friction, restitution = np.array([surface.friction]), np.array([surface.restitution])
    response, impulse, stiffness = response_of(surface), np.zeros(3), np.ones(1)
    account, log = np.zeros((1, 3)), np.zeros((0, 7))
    while True:
        outcome, error = fly(surface, ball, tolerance, segments)
        if outcome == LIES:
            break
        if outcome == ENDLESS:
            return NEVER_RESTS if surface.restitution == 1.0 else BUDGET_EXCEEDED, 0.0
        slip, x, y = slip_of(ball, surface.radius)
        approach = np.array([ball[CLIMB], slip, 0.0])
        solve(
            response, approach, friction, restitution, stiffness, surface.law, surface.exponent,
            accuracy, impulse, account, log,
        )
        push(surface, ball, x, y, impulse)
        if outcome == PAUSED:
            ball[CLIMB] = 0.0
            break
    rests = come_to_rest(surface, ball, segments)
    return OK if rests else NEVER_RESTS, error
