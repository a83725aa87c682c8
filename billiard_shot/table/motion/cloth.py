"""
A ball on the cloth: it slides, rolls, spins in place, rests. Closed forms for each.

u = v - r w x z is the velocity of the ball's lowest point. Sliding friction does not turn u, so
that the acceleration is constant and the centre follows a parabola until u = 0 (Coriolis 1835; for
a solid ball after 2 |u| / (7 mu g)). The spin about the vertical decays by itself.
"""

import math

from billiard_shot.compiled import inner, innermost
from billiard_shot.table.model.geometry import BallClothParams
from billiard_shot.table.model.motion import BallRecord, REST, ROLL, SLIDE, SPIN, stop_ball

ROUNDS = 4  # until speed and mean resistance agree


@innermost
def speed_of(ball: BallRecord, radius: float) -> float:
    """Speed scale of a ball [m/s], to tell motion from rounding."""
    largest = 0.0
    for i in range(3):
        largest = max(largest, abs(ball.velocity[i]), radius * abs(ball.spin[i]))
    return largest


@inner
def slip_of(ball: BallRecord, radius: float) -> tuple[float, float, float]:
    """Size [m/s] and direction (x, y) of the lowest point's velocity; zero if only rounding."""
    x = ball.velocity[0] - radius * ball.spin[1]
    y = ball.velocity[1] + radius * ball.spin[0]
    slip = math.sqrt(x * x + y * y)
    if slip <= 1e-14 * speed_of(ball, radius):
        return 0.0, 0.0, 0.0
    return slip, x / slip, y / slip


@innermost
def time_to_stop(speed: float, deceleration: float) -> float:
    """Time until a speed is used up, infinite without deceleration."""
    return speed / deceleration if deceleration > 0.0 else math.inf


@innermost
def rolling_share(params: BallClothParams) -> float:
    """One over the fraction of a ball's slip that its velocity gives up until it rolls."""
    return 1.0 + params.mass * (params.radius * params.radius) / params.inertia


@innermost
def set_rolling_spin(params: BallClothParams, ball: BallRecord) -> None:
    """Turn a ball as it rolls at its speed."""
    ball.spin[0] = -ball.velocity[1] / params.radius
    ball.spin[1] = ball.velocity[0] / params.radius


@inner
def start_cloth_motion(params: BallClothParams, ball: BallRecord) -> None:
    """Find what a ball on the cloth does from now on, its accelerations, and when that ends."""
    lasting, until, planned = math.inf, math.inf, True
    slip, x, y = slip_of(ball, params.radius)
    if params.sliding_friction == math.inf and slip > 0.0:
        lost = slip / rolling_share(params)
        ball.velocity[0] -= lost * x
        ball.velocity[1] -= lost * y
        set_rolling_spin(params, ball)
        slip = 0.0
    speed = math.sqrt(ball.velocity[0] * ball.velocity[0] + ball.velocity[1] * ball.velocity[1])
    spin = ball.spin[2]
    if slip > 0.0:
        ball.motion = SLIDE
        deceleration = params.sliding_friction * params.gravity
        lever = params.mass * params.radius / params.inertia
        ball.acceleration[0] = -deceleration * x
        ball.acceleration[1] = -deceleration * y
        ball.spin_acceleration[0] = -lever * deceleration * y
        ball.spin_acceleration[1] = lever * deceleration * x
        lasting = time_to_stop(slip, deceleration * (1.0 + lever * params.radius))
    elif speed > 0.0:
        ball.motion = ROLL
        deceleration = params.rolling_resistance * params.gravity
        if resistance_rises(params):
            planned = ball.time < ball.roll_until
            deceleration, until = roll_on(params, ball, speed)
        ball.acceleration[0] = -deceleration * ball.velocity[0] / speed
        ball.acceleration[1] = -deceleration * ball.velocity[1] / speed
        ball.spin_acceleration[0] = -ball.acceleration[1] / params.radius
        ball.spin_acceleration[1] = ball.acceleration[0] / params.radius
        lasting = min(time_to_stop(speed, deceleration), until - ball.time)
    elif spin != 0.0:
        ball.motion = SPIN
    else:
        stop_ball(ball, REST)
        return
    if spin != 0.0 and params.spin_deceleration > 0.0:
        ball.spin_acceleration[2] = (
            -params.spin_deceleration if spin > 0.0 else params.spin_deceleration
        )
        left = abs(spin) / params.spin_deceleration
        if left < lasting and planned:
            ball.spin_ends = True
            lasting = left
    ball.end = ball.time + lasting
    if until < math.inf and not ball.spin_ends:
        ball.end = until  # without rounding


@inner
def snap_to_segment_end(params: BallClothParams, ball: BallRecord) -> bool:
    """
    Make exact what a segment on the cloth ends in: no slip, no speed, or no spin.

    Return whether it ends in nothing of these: the ball rolls on with another deceleration.
    """
    if ball.spin_ends:
        ball.spin[2] = 0.0
        return False
    goes_on = ball.motion == ROLL and rolls_on(params, ball)
    if ball.motion == ROLL and not goes_on:
        ball.velocity[0] = 0.0
        ball.velocity[1] = 0.0
    set_rolling_spin(params, ball)
    return goes_on


@inner
def speed_to_arrive(params: BallClothParams, way: float, arrival: float) -> float:
    """Speed [m/s] with which a ball without spin has to begin to arrive at a speed after a way."""
    share = 1.0 / rolling_share(params)
    slide = params.sliding_friction * params.gravity
    if slide == 0.0:
        return arrival
    # it slides over share (1 - share / 2) v^2 / slide, and rolls off at (1 - share) v
    left, sliding = 1.0 - share, share * (1.0 - 0.5 * share) / slide
    speed = arrival
    for _ in range(ROUNDS if resistance_rises(params) else 1):
        roll = mean_deceleration(params, max(left * speed, arrival), arrival)
        square = (arrival * arrival + 2.0 * roll * way) / (left * left + 2.0 * roll * sliding)
        if sliding * square > way:
            square = arrival * arrival + 2.0 * slide * way
        speed = math.sqrt(square)
    return speed


@inner
def rolling_after(params: BallClothParams, speed: float, way: float) -> float:
    """Surface speed of the spin over the speed, of a ball without spin at first, after a way."""
    slide = 2.0 * params.sliding_friction * params.gravity * way
    if slide >= speed * speed:
        return 1.0
    now = math.sqrt(speed * speed - slide)
    return min((speed - now) * (rolling_share(params) - 1.0) / now, 1.0)


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
