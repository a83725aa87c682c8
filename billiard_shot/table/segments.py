"""From one segment of a ball to its next: what it does now, until when, and what that ends in."""

from billiard_shot.compiled import inner
from billiard_shot.table.cloth import snap_to_segment_end, start_cloth_motion
from billiard_shot.table.flight import bounce, take_off
from billiard_shot.table.motion import advance_ball, BallRecord, FLIGHT, OWN, ROLL_ON
from billiard_shot.table.params import BallClothParams


@inner
def start_segment(params: BallClothParams, ball: BallRecord, tolerance: float) -> float:
    """
    Find what a ball does from now on: motion, accelerations, end. Return the error made [m].

    `tolerance` [m] is for leaving out small bounces.
    """
    for i in range(3):
        ball.acceleration[i] = 0.0
        ball.spin_acceleration[i] = 0.0
    ball.spin_ends = False
    ball.landing_speed = 0.0
    flies, error = take_off(params, ball, tolerance)
    if not flies:
        start_cloth_motion(params, ball)
    return error


@inner
def end_segment(params: BallClothParams, ball: BallRecord) -> None:
    """Follow a ball's segment to its end, and make the change that ends it."""
    advance_ball(ball, ball.end)
    if ball.motion == FLIGHT:
        bounce(params, ball)
        ball.cause = OWN
    else:
        ball.cause = ROLL_ON if snap_to_segment_end(params, ball) else OWN
