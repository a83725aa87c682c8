"""
A ball on the cloth: it slides, rolls, spins in place, rests. Closed forms for each.

u = v - r w x z is the velocity of the ball's lowest point. Sliding friction does not turn u, so
that the acceleration is constant and the centre follows a parabola until u = 0 (Coriolis 1835; for
a solid ball after 2 |u| / (7 mu g)). The spin about the vertical decays by itself.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.table.motion import (
    ACCELERATION,
    ANGULAR,
    ANGULAR_ACCELERATION,
    follow,
    MOTION,
    REST,
    ROLL,
    SLIDE,
    SPIN,
    VELOCITY,
)
from billiard_shot.table.surface import Surface

VERTICAL_SPIN = ANGULAR + 2


@compiled
def speed_of(ball: NDArray[np.float64], radius: float) -> float:
    """Speed scale of a ball, to tell motion from rounding."""
    largest = 0.0
    for i in range(3):
        largest = max(largest, abs(ball[VELOCITY + i]), radius * abs(ball[ANGULAR + i]))
    return largest


@compiled
def slip_of(ball: NDArray[np.float64], radius: float) -> tuple[float, float, float]:
    """Size and direction (x, y) of the lowest point's velocity; zero where it is only rounding."""
    x = ball[VELOCITY] - radius * ball[ANGULAR + 1]
    y = ball[VELOCITY + 1] + radius * ball[ANGULAR]
    slip = np.hypot(x, y)
    if slip <= 1e-14 * speed_of(ball, radius):
        return 0.0, 0.0, 0.0
    return slip, x / slip, y / slip


@compiled
def time_to_stop(speed: float, deceleration: float) -> float:
    """Time until a speed is used up, infinite without deceleration."""
    return speed / deceleration if deceleration > 0.0 else np.inf


@compiled
def follow_on_cloth(
    surface: Surface, ball: NDArray[np.float64], duration: float, segments: NDArray[np.float64]
) -> None:
    """Follow a motion on the cloth, in two parts if the spin about the vertical ends meanwhile."""
    spin = ball[VERTICAL_SPIN]
    if spin != 0.0 and surface.spin_deceleration > 0.0:
        ball[ANGULAR_ACCELERATION + 2] = -np.sign(spin) * surface.spin_deceleration
        left = time_to_stop(abs(spin), surface.spin_deceleration)
        if left < duration:
            before = ball.copy()
            follow(ball, left, segments)
            for i in range(3):
                ball[ACCELERATION + i] = before[ACCELERATION + i]
                ball[ANGULAR_ACCELERATION + i] = before[ANGULAR_ACCELERATION + i]
            ball[VERTICAL_SPIN] = 0.0
            ball[ANGULAR_ACCELERATION + 2] = 0.0
            duration -= left
    follow(ball, duration, segments)


@compiled
def slide(surface: Surface, ball: NDArray[np.float64], segments: NDArray[np.float64]) -> bool:
    """Slide until the ball rolls; return whether that ever happens."""
    slip, x, y = slip_of(ball, surface.radius)
    if surface.sliding == np.inf:
        left = slip / (1.0 + surface.mass * surface.radius**2 / surface.inertia)
        ball[VELOCITY] -= left * x
        ball[VELOCITY + 1] -= left * y
    elif slip > 0.0:
        ball[MOTION] = SLIDE
        deceleration = surface.sliding * surface.gravity
        lever = surface.mass * surface.radius / surface.inertia
        ball[ACCELERATION] = -deceleration * x
        ball[ACCELERATION + 1] = -deceleration * y
        ball[ANGULAR_ACCELERATION] = -lever * deceleration * y
        ball[ANGULAR_ACCELERATION + 1] = lever * deceleration * x
        duration = time_to_stop(slip, deceleration * (1.0 + lever * surface.radius))
        follow_on_cloth(surface, ball, duration, segments)
        if duration == np.inf:
            return False
    ball[ANGULAR] = -ball[VELOCITY + 1] / surface.radius
    ball[ANGULAR + 1] = ball[VELOCITY] / surface.radius
    return True


@compiled
def roll(surface: Surface, ball: NDArray[np.float64], segments: NDArray[np.float64]) -> bool:
    """Roll until the ball's centre stands still; return whether that ever happens."""
    speed = np.hypot(ball[VELOCITY], ball[VELOCITY + 1])
    if speed > 0.0:
        ball[MOTION] = ROLL
        deceleration = surface.rolling * surface.gravity
        ball[ACCELERATION] = -deceleration * ball[VELOCITY] / speed
        ball[ACCELERATION + 1] = -deceleration * ball[VELOCITY + 1] / speed
        ball[ANGULAR_ACCELERATION] = -ball[ACCELERATION + 1] / surface.radius
        ball[ANGULAR_ACCELERATION + 1] = ball[ACCELERATION] / surface.radius
        duration = time_to_stop(speed, deceleration)
        follow_on_cloth(surface, ball, duration, segments)
        if duration == np.inf:
            return False
    for i in range(2):
        ball[VELOCITY + i] = 0.0
        ball[ANGULAR + i] = 0.0
    return True


@compiled
def come_to_rest(
    surface: Surface, ball: NDArray[np.float64], segments: NDArray[np.float64]
) -> bool:
    """Follow a ball that lies on the cloth to the end; return whether it ever rests."""
    if not slide(surface, ball, segments) or not roll(surface, ball, segments):
        return False
    if ball[VERTICAL_SPIN] != 0.0:
        ball[MOTION] = SPIN
        duration = time_to_stop(abs(ball[VERTICAL_SPIN]), surface.spin_deceleration)
        follow_on_cloth(surface, ball, duration, segments)
        if duration == np.inf:
            return False
        ball[VERTICAL_SPIN] = 0.0
    ball[MOTION] = REST
    follow(ball, np.inf, segments)
    return True
