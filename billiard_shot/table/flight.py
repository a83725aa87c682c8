"""
A ball in the air: parabolas, and between them bounces, each an impact of billiard_shot.impact.

Bounces get smaller without end. Those that are not worth resolving are done at once, exactly as
far as their sums go: after leaving the cloth at speed s, with restitution e, the ball hops for
2 s / (g (1 - e)) and the cloth pushes it with m s (1 + e) / (1 - e) in all. That is one level
pause, and one bounce from a fall at s / (1 - e), after which the ball stays down.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import compiled
from billiard_shot.table.cloth import slip_of, speed_of
from billiard_shot.table.motion import (
    ACCELERATION,
    ANGULAR,
    COUNT,
    FLIGHT,
    follow,
    MOTION,
    POSITION,
    VELOCITY,
)
from billiard_shot.table.surface import OFF, ON, Surface

MAX_BOUNCES = 1000  # more than it takes at restitution 0.99
HEIGHT, CLIMB = POSITION + 2, VELOCITY + 2
LIES, HOPPED, PAUSED, ENDLESS = 0, 1, 2, 3  # what came of a try to fly


@compiled
def error_of_pause(surface: Surface, ball: NDArray[np.float64]) -> float:
    """
    Bound of the error in position [m] if all further hops are done at once.

    The height that is left out; and the change of velocity that the cloth makes, which comes at
    the end of the pause instead of in the course of it.
    """
    if surface.restitution == 1.0:
        return np.inf
    up = ball[CLIMB]
    slip, _, _ = slip_of(ball, surface.radius)
    stopping = slip / (1.0 + surface.mass * surface.radius**2 / surface.inertia)
    push = surface.friction * up * (1.0 + surface.restitution) / (1.0 - surface.restitution)
    pause = 2.0 * up / (surface.gravity * (1.0 - surface.restitution))
    height = 0.5 * up * up / surface.gravity
    error: float = max(height, min(push, stopping) * pause)
    return error


@compiled
def fly(
    surface: Surface, ball: NDArray[np.float64], tolerance: float, segments: NDArray[np.float64]
) -> tuple[int, float]:
    """
    Follow a ball that may leave the cloth until just before it comes down to it.

    Returns
    -------
    outcome, error : int, float
        LIES: it does not leave the cloth. HOPPED: it falls, and will bounce. PAUSED: it falls, as
        if all its bounces came at once, and will lie; `error` is the bound of that [m], at most
        `tolerance`. ENDLESS: it bounces for ever; the rest of that is written down as level.

    """
    first = ball[COUNT] == 0.0
    least = 1e-14 * speed_of(ball, surface.radius)  # less is rounding
    if ball[CLIMB] <= least or (surface.flight == OFF and first):
        ball[CLIMB] = 0.0
        return LIES, 0.0
    ball[MOTION] = FLIGHT
    slip, _, _ = slip_of(ball, surface.radius)
    periodic = surface.restitution == 1.0 and (slip == 0.0 or surface.friction == 0.0)
    if ball[COUNT] >= MAX_BOUNCES or (periodic and not first):
        ball[CLIMB] = 0.0
        follow(ball, np.inf, segments)
        return ENDLESS, 0.0
    error = error_of_pause(surface, ball)
    if error > tolerance or surface.bounce == ON or (surface.flight == ON and first):
        ball[ACCELERATION + 2] = -surface.gravity
        follow(ball, 2.0 * ball[CLIMB] / surface.gravity, segments)
        ball[HEIGHT] = surface.radius
        return HOPPED, 0.0
    fall = ball[CLIMB] / (1.0 - surface.restitution)
    ball[CLIMB] = 0.0
    follow(ball, 2.0 * fall / surface.gravity, segments)
    ball[CLIMB] = -fall
    return PAUSED, error


@compiled
def response_of(surface: Surface) -> NDArray[np.float64]:
    """W (3, 3) of a ball on the cloth [1/kg]: up, along its slip and across it."""
    response = np.zeros((3, 3))
    response[0, 0] = 1.0 / surface.mass
    response[1, 1] = 1.0 / surface.mass + surface.radius**2 / surface.inertia
    response[2, 2] = response[1, 1]
    return response


@compiled
def push(
    surface: Surface, ball: NDArray[np.float64], x: float, y: float, impulse: NDArray[np.float64]
) -> None:
    """Change velocity and spin by an impulse of the cloth: up, and along the slip's (x, y)."""
    ball[CLIMB] += impulse[0] / surface.mass
    ball[VELOCITY] += x * impulse[1] / surface.mass
    ball[VELOCITY + 1] += y * impulse[1] / surface.mass
    ball[ANGULAR] += surface.radius * y * impulse[1] / surface.inertia
    ball[ANGULAR + 1] -= surface.radius * x * impulse[1] / surface.inertia
