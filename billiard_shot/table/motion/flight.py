"""
A ball in the air: parabolas, and between them bounces.

Bounces get smaller without end (a Zeno sequence). Those too small to resolve are lumped into one
event that has exactly their sums. After leaving the cloth at speed s, with restitution e, the ball
bounces for 2 s / (g (1 - e)), and the cloth's impulse is m s (1 + e) / (1 - e) in all. So the ball
moves on level for that time, and then lands once, at s / (1 - e), and stays down.
"""

import math

from billiard_shot.compiled import inner
from billiard_shot.table.model.geometry import BallClothParams, GATE_OFF, GATE_ON
from billiard_shot.table.model.motion import BallRecord, FLIGHT
from billiard_shot.table.motion.ball_impact import collide_fixed
from billiard_shot.table.motion.cloth import rolling_share, slip_of, speed_of

MAX_BOUNCES = 1000  # more than it takes at restitution 0.99
LYING = 1e-9  # relative to the radius: height above the cloth that is only rounding
LOWEST = 1e-20  # relative to the radius: height of a bounce that is lost in rounding


@inner
def lumped_bounce_error(params: BallClothParams, ball: BallRecord, up: float) -> float:
    """
    Bound of the error in position [m] if all bounces from a speed `up` [m/s] on are lumped.

    It is the larger of two: the height that is left out; and the change of velocity by the cloth,
    which comes at the end instead of bit by bit, times how long that is.
    """
    if params.cloth_restitution == 1.0:
        return math.inf
    slip, _, _ = slip_of(ball, params.radius)
    stopping = slip / rolling_share(params)
    push = (
        params.cloth_friction
        * up
        * (1.0 + params.cloth_restitution)
        / (1.0 - params.cloth_restitution)
    )
    pause = 2.0 * up / (params.gravity * (1.0 - params.cloth_restitution))
    height = 0.5 * up * up / params.gravity
    return max(height, min(push, stopping) * pause)


@inner
def take_off(params: BallClothParams, ball: BallRecord, tolerance: float) -> tuple[bool, float]:
    """
    Let a ball fly that leaves the cloth or is above it, until it comes down.

    Returns
    -------
    flies, error : bool, float
        Whether it does. The bound of the error [m], at most `tolerance`, of a flight that stands
        for all the bounces that follow. An endless series of bounces ends in an endless motion.

    """
    above = ball.position[2] - params.radius
    lowest = math.sqrt(2.0 * params.gravity * LOWEST * params.radius)
    least = max(1e-14 * speed_of(ball, params.radius), lowest)  # less is rounding
    if above <= LYING * params.radius:
        above = 0.0
        ball.position[2] = params.radius
        if ball.velocity[2] <= least or (params.flight_gate == GATE_OFF and ball.bounces == 0):
            ball.velocity[2] = 0.0
            return False, 0.0
    ball.motion = FLIGHT
    up = ball.velocity[2]
    slip, _, _ = slip_of(ball, params.radius)
    periodic = params.cloth_restitution == 1.0 and (slip == 0.0 or params.cloth_friction == 0.0)
    if above == 0.0 and (ball.bounces >= MAX_BOUNCES or (periodic and ball.bounces > 0)):
        ball.velocity[2] = 0.0
        ball.end = math.inf
        return True, 0.0
    resolved = params.bounce_gate == GATE_ON or (
        params.flight_gate == GATE_ON and ball.bounces == 0
    )
    if above == 0.0 and not resolved:
        error = lumped_bounce_error(params, ball, up)
        if error <= tolerance:
            ball.landing_speed = up / (1.0 - params.cloth_restitution)
            ball.velocity[2] = 0.0
            ball.end = ball.time + 2.0 * ball.landing_speed / params.gravity
            return True, error
    ball.acceleration[2] = -params.gravity
    fall = math.sqrt(up * up + 2.0 * params.gravity * above)
    lasting = (up + fall) / params.gravity
    ball.end = ball.time + max(lasting, 0.0)
    return True, 0.0


@inner
def bounce_on_cloth(params: BallClothParams, ball: BallRecord) -> None:
    """Let a ball that comes down to the cloth leave it again; after lumped bounces it stays."""
    lumped = ball.landing_speed > 0.0
    if lumped:
        ball.velocity[2] = -ball.landing_speed
    ball.position[2] = params.radius
    collide_fixed(
        params, ball, 0.0, 0.0, 1.0, params.cloth_restitution, friction=params.cloth_friction
    )
    if lumped:
        ball.velocity[2] = 0.0
    ball.bounces += 1
