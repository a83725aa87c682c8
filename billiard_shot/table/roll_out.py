"""All that a ball does on an empty, unbounded table, from one state to rest."""

import math

from billiard_shot.compiled import inner
from billiard_shot.status import BUDGET_EXCEEDED, NEVER_RESTS, OK
from billiard_shot.table.motion import append_segment, Ball, FLIGHT, REST, Segment
from billiard_shot.table.params import BallClothParams
from billiard_shot.table.segments import end_segment, start_segment


@inner
def ending(params: BallClothParams, ball: Ball) -> int:
    """Status of a ball in its last segment: OK, NEVER_RESTS or BUDGET_EXCEEDED."""
    if ball.motion == FLIGHT and params.cloth_restitution < 1.0:
        return BUDGET_EXCEEDED
    return OK if ball.motion == REST or ball.motion > FLIGHT else NEVER_RESTS


@inner
def roll_out(
    params: BallClothParams, ball: Ball, tolerance: float, segments: list[Segment]
) -> tuple[int, float]:
    """
    Follow a ball until it rests.

    Parameters
    ----------
    params : BallClothParams
    ball : Ball, changed
        From `start_ball`. In the end it is at rest or, if it never rests, where its last, endless
        segment begins.
    tolerance : float
        For leaving out small bounces [m].
    segments : records of Segment, written
        The motion, as far as there is room; `ball.segments` counts all.

    Returns
    -------
    status, error : int, float
        OK, NEVER_RESTS or BUDGET_EXCEEDED; the bound of the error made by leaving out bounces [m].

    """
    error = start_segment(params, ball, tolerance)
    append_segment(ball, segments)
    while ball.end < math.inf:
        end_segment(params, ball)
        error = max(error, start_segment(params, ball, tolerance))
        append_segment(ball, segments)
    return ending(params, ball), error
