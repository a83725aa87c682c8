"""
A ball on the cloth: it slides, rolls, spins in place, rests. Closed forms for each.

u = v - r w x z is the velocity of the ball's lowest point. Sliding friction does not turn u, so
that the acceleration is constant and the centre follows a parabola until u = 0 (Coriolis 1835; for
a solid ball after 2 |u| / (7 mu g)). The spin about the vertical decays by itself.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.motion import (
    ACCELERATION,
    ANGULAR,
    ANGULAR_ACCELERATION,
    END,
    halt,
    MOTION,
    REST,
    ROLL,
    SLIDE,
    SPIN,
    SPIN_ENDS,
    TIME,
    VELOCITY,
    VERTICAL_SPIN,
)
from billiard_shot.table.surface import Surface


@fused
def speed_of(ball: NDArray[np.float64], radius: float) -> float:
    """Speed scale of a ball, to tell motion from rounding."""
    largest = 0.0
    for i in range(3):
        largest = max(largest, abs(ball[VELOCITY + i]), radius * abs(ball[ANGULAR + i]))
    return largest


@fused
def slip_of(ball: NDArray[np.float64], radius: float) -> tuple[float, float, float]:
    """Size and direction (x, y) of the lowest point's velocity; zero where it is only rounding."""
    x = ball[VELOCITY] - radius * ball[ANGULAR + 1]
    y = ball[VELOCITY + 1] + radius * ball[ANGULAR]
    slip = np.sqrt(x * x + y * y)
    if slip <= 1e-14 * speed_of(ball, radius):
        return 0.0, 0.0, 0.0
    return slip, x / slip, y / slip


@fused
def time_to_stop(speed: float, deceleration: float) -> float:
    """Time until a speed is used up, infinite without deceleration."""
    return speed / deceleration if deceleration > 0.0 else np.inf


@fused
def roll_with(surface: Surface, ball: NDArray[np.float64]) -> None:
    """Turn a ball as it rolls at its speed."""
    ball[ANGULAR] = -ball[VELOCITY + 1] / surface.radius
    ball[ANGULAR + 1] = ball[VELOCITY] / surface.radius


@fused
def lie(surface: Surface, ball: NDArray[np.float64]) -> None:
    """Find what a ball on the cloth does from now on, its accelerations, and when it ends."""
    lasting = np.inf
    slip, x, y = slip_of(ball, surface.radius)
    if surface.sliding == np.inf and slip > 0.0:
        left = slip / (1.0 + surface.mass * surface.radius**2 / surface.inertia)
        ball[VELOCITY] -= left * x
        ball[VELOCITY + 1] -= left * y
        roll_with(surface, ball)
        slip = 0.0
    speed = np.sqrt(ball[VELOCITY] ** 2 + ball[VELOCITY + 1] ** 2)
    if slip > 0.0:
        ball[MOTION] = SLIDE
        deceleration = surface.sliding * surface.gravity
        lever = surface.mass * surface.radius / surface.inertia
        ball[ACCELERATION] = -deceleration * x
        ball[ACCELERATION + 1] = -deceleration * y
        ball[ANGULAR_ACCELERATION] = -lever * deceleration * y
        ball[ANGULAR_ACCELERATION + 1] = lever * deceleration * x
        lasting = time_to_stop(slip, deceleration * (1.0 + lever * surface.radius))
    elif speed > 0.0:
        ball[MOTION] = ROLL
        deceleration = surface.rolling * surface.gravity
        ball[ACCELERATION] = -deceleration * ball[VELOCITY] / speed
        ball[ACCELERATION + 1] = -deceleration * ball[VELOCITY + 1] / speed
        ball[ANGULAR_ACCELERATION] = -ball[ACCELERATION + 1] / surface.radius
        ball[ANGULAR_ACCELERATION + 1] = ball[ACCELERATION] / surface.radius
        lasting = time_to_stop(speed, deceleration)
    elif ball[VERTICAL_SPIN] != 0.0:
        ball[MOTION] = SPIN
    else:
        halt(ball, REST)
        return
    spin = ball[VERTICAL_SPIN]
    if spin != 0.0 and surface.spin_deceleration > 0.0:
        ball[ANGULAR_ACCELERATION + 2] = -np.sign(spin) * surface.spin_deceleration
        left = abs(spin) / surface.spin_deceleration
        if left < lasting:
            ball[SPIN_ENDS] = 1.0
            lasting = left
    ball[END] = ball[TIME] + lasting


@fused
def settle(surface: Surface, ball: NDArray[np.float64]) -> None:
    """Make exact what the end of a motion on the cloth brings: no slip, no speed, or no spin."""
    if ball[SPIN_ENDS] != 0.0:
        ball[VERTICAL_SPIN] = 0.0
        return
    if ball[MOTION] == ROLL:
        ball[VELOCITY] = 0.0
        ball[VELOCITY + 1] = 0.0
    roll_with(surface, ball)
