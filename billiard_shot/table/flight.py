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
from billiard_shot.impact.kernel import solve
from billiard_shot.status import Status
from billiard_shot.table.cloth import slip_of, speed_of
from billiard_shot.table.motion import ACCELERATION, ANGULAR, FLIGHT, follow, POSITION, VELOCITY
from billiard_shot.table.surface import OFF, ON, Surface

MAX_BOUNCES = 2000
HEIGHT, CLIMB = POSITION + 2, VELOCITY + 2

OK = int(Status.OK)
NEVER_RESTS = int(Status.NEVER_RESTS)
BUDGET_EXCEEDED = int(Status.BUDGET_EXCEEDED)


@compiled
def bounce(
    surface: Surface, row: NDArray[np.float64], restitution: float, accuracy: float
) -> None:
    """Change velocity and spin of a ball that meets the cloth; accuracy relative to its speed."""
    x, y = slip_of(row, surface.radius)
    slip = np.hypot(x, y)
    if slip > 0.0:
        x, y = x / slip, y / slip
    # contact space: up, along the slip, across it; a ball's three do not influence each other
    response = np.zeros((3, 3))
    response[0, 0] = 1.0 / surface.mass
    response[1, 1] = 1.0 / surface.mass + surface.radius**2 / surface.inertia
    response[2, 2] = response[1, 1]
    impulse = np.zeros(3)
    solve(
        response, np.array([row[CLIMB], slip, 0.0]), np.array([surface.friction]),
        np.array([restitution]), np.ones(1), surface.law, surface.exponent, accuracy,
        impulse, np.zeros((1, 3)), np.zeros((0, 7)),
    )
    row[CLIMB] += impulse[0] / surface.mass
    row[VELOCITY] += x * impulse[1] / surface.mass
    row[VELOCITY + 1] += y * impulse[1] / surface.mass
    row[ANGULAR] += surface.radius * y * impulse[1] / surface.inertia
    row[ANGULAR + 1] -= surface.radius * x * impulse[1] / surface.inertia


@compiled
def error_of_pause(surface: Surface, row: NDArray[np.float64], restitution: float) -> float:
    """
    Bound of the error in position [m] if all further hops are done at once.

    The height that is left out; and the change of velocity that the cloth makes, which comes at
    the end of the pause instead of in the course of it.
    """
    up = row[CLIMB]
    if restitution == 1.0:
        return np.inf
    x, y = slip_of(row, surface.radius)
    stopping = np.hypot(x, y) / (1.0 + surface.mass * surface.radius**2 / surface.inertia)
    push = surface.friction * up * (1.0 + restitution) / (1.0 - restitution)
    pause = 2.0 * up / (surface.gravity * (1.0 - restitution))
    height = 0.5 * up * up / surface.gravity
    error: float = max(height, min(push, stopping) * pause)
    return error


@compiled
def fly(
    surface: Surface, row: NDArray[np.float64], tolerance: float, accuracy: float,
    segments: NDArray[np.float64],
) -> tuple[int, float, int]:
    """
    Follow a ball from where it leaves the cloth until it stays on it.

    Parameters
    ----------
    tolerance : float
        Allowed for leaving out bounces [m].
    accuracy : float
        Of each bounce, relative to the ball's speed.

    Returns
    -------
    count, error, status : int, float, int
        Segments written, the bound of the error made [m], OK or why it never stays down.

    """
    count = 0
    least = 1e-14 * speed_of(row, surface.radius)  # less is rounding
    if surface.flight == OFF or row[CLIMB] <= least:
        row[CLIMB] = 0.0
        return count, 0.0, OK
    restitution = 0.0 if surface.bounce == OFF else surface.restitution
    error = error_of_pause(surface, row, restitution)
    while error > tolerance or (count == 0 and surface.flight == ON):
        row[ACCELERATION + 2] = -surface.gravity
        count = follow(row, FLIGHT, 2.0 * row[CLIMB] / surface.gravity, segments, count)
        row[HEIGHT] = surface.radius
        bounce(surface, row, restitution, accuracy)
        if row[CLIMB] <= least:
            row[CLIMB] = 0.0
            return count, 0.0, OK
        if count == MAX_BOUNCES:  # the rest of this endless flight is written down as level
            row[CLIMB] = 0.0
            count = follow(row, FLIGHT, np.inf, segments, count)
            return count, 0.0, NEVER_RESTS if restitution == 1.0 else BUDGET_EXCEEDED
        error = error_of_pause(surface, row, restitution)
    landing = -row[CLIMB] / (1.0 - restitution)
    row[CLIMB] = 0.0
    count = follow(row, FLIGHT, -2.0 * landing / surface.gravity, segments, count)
    row[CLIMB] = landing
    bounce(surface, row, restitution, accuracy)
    row[CLIMB] = 0.0
    return count, error, OK
