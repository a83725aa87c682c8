"""
A ball in the air: parabolas, and between them bounces.

Bounces get smaller without end. Those that are not worth resolving are done at once, exactly as
far as their sums go: after leaving the cloth at speed s, with restitution e, the ball hops for
2 s / (g (1 - e)) and the cloth pushes it with m s (1 + e) / (1 - e) in all. That is one level
pause, and one bounce from a fall at s / (1 - e), after which the ball stays down.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.cloth import slip_of, speed_of
from billiard_shot.table.motion import (
    ACCELERATION,
    CLIMB,
    END,
    FALL,
    FLIGHT,
    HEIGHT,
    HOPS,
    MOTION,
    TIME,
)
from billiard_shot.table.sphere import strike_fixed
from billiard_shot.table.surface import OFF, ON, Surface

MAX_HOPS = 1000  # more than it takes at restitution 0.99
LYING = 1e-9  # in radii: height above the cloth that is only rounding
LOWEST = 1e-20  # in radii: height of a hop that is lost in rounding


@fused
def error_of_pause(surface: Surface, ball: NDArray[np.float64], up: float) -> float:
    """
    Bound of the error in position [m] if all hops from a speed `up` [m/s] on are done at once.

    The height that is left out; and the change of velocity that the cloth makes, which comes at
    the end of the pause instead of in the course of it.
    """
    if surface.restitution == 1.0:
        return np.inf
    slip, _, _ = slip_of(ball, surface.radius)
    stopping = slip / (1.0 + surface.mass * surface.radius**2 / surface.inertia)
    push = surface.friction * up * (1.0 + surface.restitution) / (1.0 - surface.restitution)
    pause = 2.0 * up / (surface.gravity * (1.0 - surface.restitution))
    height = 0.5 * up * up / surface.gravity
    error: float = max(height, min(push, stopping) * pause)
    return error


@fused
def take_off(
    surface: Surface, ball: NDArray[np.float64], tolerance: float
) -> tuple[bool, float]:
    """
    Let a ball fly that leaves the cloth or is above it, until it comes down.

    Returns
    -------
    flies, error : bool, float
        Whether it does. The bound of the error [m], at most `tolerance`, of a flight that stands
        for all the bounces that follow. An endless series of bounces ends in an endless motion.

    """
    above = ball[HEIGHT] - surface.radius
    lowest = np.sqrt(2.0 * surface.gravity * LOWEST * surface.radius)
    least = max(1e-14 * speed_of(ball, surface.radius), lowest)  # less is rounding
    if above <= LYING * surface.radius:
        above = 0.0
        ball[HEIGHT] = surface.radius
        if ball[CLIMB] <= least or (surface.flight == OFF and ball[HOPS] == 0.0):
            ball[CLIMB] = 0.0
            return False, 0.0
    ball[MOTION] = FLIGHT
    up = ball[CLIMB]
    slip, _, _ = slip_of(ball, surface.radius)
    periodic = surface.restitution == 1.0 and (slip == 0.0 or surface.friction == 0.0)
    if above == 0.0 and (ball[HOPS] >= MAX_HOPS or (periodic and ball[HOPS] > 0.0)):
        ball[CLIMB] = 0.0
        ball[END] = np.inf
        return True, 0.0
    followed = surface.bounce == ON or (surface.flight == ON and ball[HOPS] == 0.0)
    if above == 0.0 and not followed:
        error = error_of_pause(surface, ball, up)
        if error <= tolerance:
            ball[FALL] = up / (1.0 - surface.restitution)
            ball[CLIMB] = 0.0
            ball[END] = ball[TIME] + 2.0 * ball[FALL] / surface.gravity
            return True, error
    ball[ACCELERATION + 2] = -surface.gravity
    fall = np.sqrt(up * up + 2.0 * surface.gravity * above)
    lasting = (up + fall) / surface.gravity
    ball[END] = ball[TIME] + max(lasting, 0.0)
    return True, 0.0


@fused
def bounce(surface: Surface, ball: NDArray[np.float64]) -> None:
    """Let a ball that comes down to the cloth leave it again; after a pause it stays down."""
    paused = ball[FALL] > 0.0
    if paused:
        ball[CLIMB] = -ball[FALL]
    ball[HEIGHT] = surface.radius
    strike_fixed(surface, ball, 0.0, 0.0, 1.0, surface.restitution, surface.friction)
    if paused:
        ball[CLIMB] = 0.0
    ball[HOPS] += 1.0
