"""
Rolling against a resistance that rises with speed, in stretches of constant deceleration.

At the speed v the deceleration is g (c + k v): c is the resistance at rest, k its rise. So the
deceleration decays exponentially at the `rate` g k. After the time t of a roll that begins at the
speed u and with the deceleration a,
    way = u t - a t^2 lag(g k t) ,   speed = u - g c t - g k way .

If a short stretch has one deceleration, the speed at its end is exact, and the way errs by
g k a t^3 / 12 (the error of the trapezoidal rule). If the two halves of a stretch have a
deceleration each, speed and way at its end are exact. A stretch is planned to end where the ball
meets something of the table, so that the ball meets it at the right speed.
"""

import math

from billiard_shot.compiled import inner, innermost
from billiard_shot.table.motion import BallRecord
from billiard_shot.table.params import BallClothParams

SINGLE = 1.0 / 16.0  # of the tolerance: largest error of a stretch of one deceleration
# A stretch in two halves may last this many times as long. Within it the ball errs by up to 0.15
# of the tolerance.
HALVES = 4.0
LONGEST = 0.25  # stretch, times the rate: so that `lag` errs by 1e-7
FINEST = 1e-11  # tolerance, relative to about the way to rest
NEWTON_STEPS = 3
LEAST = 1e-100  # deceleration [m/s^2] and rate [1/s]: their product is above 0
NO_PLAN = -math.inf  # s, in place of the end of a stretch


@innermost
def resistance_rises(params: BallClothParams) -> bool:
    """Whether it does; without resistance at rest a rise is ignored: no roll would end."""
    least = LEAST / params.gravity
    return params.rolling_rise > least and params.rolling_resistance > least


@innermost
def lag(z: float) -> float:
    """Return (z - 1 + exp(-z)) / z^2 for a small z, by its series."""
    return 0.5 * (1.0 - z / 3.0 * (1.0 - z / 4.0 * (1.0 - z / 5.0 * (1.0 - z / 6.0))))


@innermost
def mean_deceleration(params: BallClothParams, fast: float, slow: float) -> float:
    """Find the deceleration [m/s^2] that takes about as long a way from one speed to another."""
    mean = (2.0 / 3.0) * (fast - slow * fast / (fast + slow) + slow) if fast > 0.0 else 0.0
    return (params.rolling_resistance + params.rolling_rise * mean) * params.gravity


@inner
def time_of_way(
    params: BallClothParams, speed: float, slowing: float, way: float, guess: float
) -> float:
    """Improve a guess of the time [s] that a rolling ball takes for a way [m]."""
    rate, time = params.rolling_rise * params.gravity, guess
    for _ in range(NEWTON_STEPS):
        gone = (speed - slowing * time * lag(rate * time)) * time
        now = speed - params.rolling_resistance * params.gravity * time - rate * gone
        time += (way - gone) / max(now, 0.25 * speed)
    return time


@innermost
def time_to_rest(rate: float, speed: float, slowing: float) -> float:
    """Find the time [s] until a rolling ball rests, if it is at most `LONGEST` / rate."""
    time = speed / slowing
    for _ in range(NEWTON_STEPS):
        z = rate * time
        time += (speed / slowing - time * (1.0 - z * lag(z))) / (1.0 - z + 0.5 * z * z)
    return time


@inner
def plan_roll(params: BallClothParams, ball: BallRecord, tolerance: float) -> None:
    """
    Plan the decelerations of the stretch of rolling that a ball begins.

    Parameters
    ----------
    params : BallClothParams
    ball : BallRecord, changed
        At its `boundary_time` it would meet something of the table without a plan.
    tolerance : float
        [m].

    """
    v = ball.velocity
    speed = math.sqrt(v[0] * v[0] + v[1] * v[1])
    rate = params.rolling_rise * params.gravity
    slowing = params.rolling_resistance * params.gravity + rate * speed
    allowed = SINGLE * max(tolerance, FINEST * speed * speed / slowing)
    short = (12.0 * allowed / (rate * slowing)) ** (1.0 / 3.0)
    longest = min(HALVES * short, LONGEST / rate)
    lasting, meets = longest, ball.boundary_time - ball.time
    if meets < 2.0 * longest:
        way = (speed - 0.5 * mean_deceleration(params, speed, 0.0) * meets) * meets
        lasting = min(longest, time_of_way(params, speed, slowing, way, meets))
    ball.roll_until = ball.time + longest
    z = rate * lasting
    if speed <= slowing * lasting * (1.0 - z * lag(z)):
        lasting, ball.roll_until = time_to_rest(rate, speed, slowing), math.inf
        z = rate * lasting
    if lasting <= short:
        ball.roll_turn, ball.roll_then = -math.inf, slowing * (1.0 - z * lag(z))
    else:
        ball.roll_turn = ball.time + 0.5 * lasting
        ball.roll_first = slowing * ((4.0 + z) * lag(z) - 1.0)
        ball.roll_then = slowing * (3.0 - (4.0 + 3.0 * z) * lag(z))


@inner
def roll_on(params: BallClothParams, ball: BallRecord, speed: float) -> tuple[float, float]:
    """
    Find the deceleration [m/s^2] of a rolling ball, and the time when it changes [s], or inf.

    Without a plan, the deceleration is the mean of all that follows.
    """
    if ball.time >= ball.roll_until:
        return mean_deceleration(params, speed, 0.0), math.inf
    if ball.time < ball.roll_turn:
        return ball.roll_first, ball.roll_turn
    if speed <= ball.roll_then * (ball.roll_until - ball.time):
        ball.roll_until = math.inf
    return ball.roll_then, ball.roll_until


@innermost
def rolls_on(params: BallClothParams, ball: BallRecord) -> bool:
    """Whether a rolling ball whose segment ends does not rest."""
    rests = ball.roll_until == math.inf and ball.time > ball.roll_turn
    return resistance_rises(params) and not rests
