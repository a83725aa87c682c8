"""All that a ball does on an empty, unbounded table, from one state to rest."""

import math

from billiard_shot.compiled import inner
from billiard_shot.status import BUDGET_EXCEEDED, NEVER_RESTS, OK
from billiard_shot.table.ball_collision import collision_time
from billiard_shot.table.motion import append_segment, Ball, FLIGHT, RELEASE, REST, Segment
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
    params: BallClothParams,
    ball: Ball,
    tolerance: float,
    segments: list[Segment],
    cue: Ball,
    reach: float,
) -> tuple[int, float, float]:
    """
    Follow a ball until it rests; see whether a cue that follows meets it.

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
    cue : Ball
        The sphere of the tip, until its `end`.
    reach : float
        Distance of the centres of tip and ball as they meet [m].

    Returns
    -------
    status, error, met : int, float, float
        OK, NEVER_RESTS or BUDGET_EXCEEDED; the bound of the error made by leaving out bounces [m];
        when the cue first meets the ball [s], or inf.

    """
    error = start_segment(params, ball, tolerance)
    append_segment(ball, segments)
    met = meeting_time(ball, cue, reach)
    while ball.end < math.inf:
        end_segment(params, ball)
        error = max(error, start_segment(params, ball, tolerance))
        append_segment(ball, segments)
        if ball.time < cue.end and met == math.inf:
            met = meeting_time(ball, cue, reach)
    return ending(params, ball), error, met


@inner
def meeting_time(ball: Ball, cue: Ball, reach: float) -> float:
    """
    When a cue meets a ball in the ball's present segment [s], or inf.

    If they meet at once, the ball has not been clear of the cue yet: it holds the cue's end aside,
    and that is no hit. But it is one if the ball comes back from a cushion that it pressed.
    """
    end = min(ball.end, cue.end)
    if ball.time >= end:
        return math.inf
    time = collision_time(cue, ball, ball.time, end, reach)
    comes_back = ball.cause == RELEASE and ball.time > cue.time  # and not from a hit
    return time if time > ball.time or comes_back else math.inf
