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
    REST,
    ROLL,
    SLIDE,
    SPIN,
    VELOCITY,
)
from billiard_shot.table.surface import Surface

VERTICAL_SPIN = ANGULAR + 2


@compiled
def speed_of(row: NDArray[np.float64], radius: float) -> float:
    """Speed scale of a ball, to tell motion from rounding."""
    largest = 0.0
    for i in range(3):
        largest = max(largest, abs(row[VELOCITY + i]), radius * abs(row[ANGULAR + i]))
    return largest


@compiled
def slip_of(row: NDArray[np.float64], radius: float) -> tuple[float, float]:
    """Horizontal velocity of the ball's lowest point; zero where it is only rounding."""
    x = row[VELOCITY] - radius * row[ANGULAR + 1]
    y = row[VELOCITY + 1] + radius * row[ANGULAR]
    if np.hypot(x, y) <= 1e-14 * speed_of(row, radius):
        return 0.0, 0.0
    return x, y


@compiled
def follow_spinning(
    surface: Surface, row: NDArray[np.float64], motion: int, duration: float,
    segments: NDArray[np.float64], count: int,
) -> int:
    """Follow a motion on the cloth, in two parts if the spin about the vertical ends meanwhile."""
    spin = row[VERTICAL_SPIN]
    if spin != 0.0 and surface.spin_deceleration > 0.0:
        row[ANGULAR_ACCELERATION + 2] = -np.sign(spin) * surface.spin_deceleration
        left = abs(spin) / surface.spin_deceleration
        if left < duration:
            forces = row.copy()
            count = follow(row, motion, left, segments, count)
            row[VERTICAL_SPIN] = 0.0
            row[ACCELERATION:ANGULAR] = forces[ACCELERATION:ANGULAR]
            row[ANGULAR_ACCELERATION:] = forces[ANGULAR_ACCELERATION:]
            row[ANGULAR_ACCELERATION + 2] = 0.0
            duration -= left
    return follow(row, motion, duration, segments, count)


@compiled
def slide(
    surface: Surface, row: NDArray[np.float64], segments: NDArray[np.float64], count: int
) -> tuple[int, bool]:
    """Slide until the ball rolls; return the count of segments and whether that ever happens."""
    x, y = slip_of(row, surface.radius)
    slip = np.hypot(x, y)
    if slip > 0.0:
        deceleration = surface.sliding * surface.gravity
        lever = surface.mass * surface.radius / surface.inertia
        row[ACCELERATION] = -deceleration * x / slip
        row[ACCELERATION + 1] = -deceleration * y / slip
        row[ANGULAR_ACCELERATION] = lever * row[ACCELERATION + 1]
        row[ANGULAR_ACCELERATION + 1] = -lever * row[ACCELERATION]
        duration = slip / (deceleration * (1.0 + lever * surface.radius))
        count = follow_spinning(surface, row, SLIDE, duration, segments, count)
        if duration == np.inf:
            return count, False
    row[ANGULAR] = -row[VELOCITY + 1] / surface.radius
    row[ANGULAR + 1] = row[VELOCITY] / surface.radius
    return count, True


@compiled
def roll(
    surface: Surface, row: NDArray[np.float64], segments: NDArray[np.float64], count: int
) -> tuple[int, bool]:
    """Roll until the ball's centre stands still; return as `slide` does."""
    speed = np.hypot(row[VELOCITY], row[VELOCITY + 1])
    if speed > 0.0:
        deceleration = surface.rolling * surface.gravity
        row[ACCELERATION] = -deceleration * row[VELOCITY] / speed
        row[ACCELERATION + 1] = -deceleration * row[VELOCITY + 1] / speed
        row[ANGULAR_ACCELERATION] = -row[ACCELERATION + 1] / surface.radius
        row[ANGULAR_ACCELERATION + 1] = row[ACCELERATION] / surface.radius
        duration = speed / deceleration
        count = follow_spinning(surface, row, ROLL, duration, segments, count)
        if duration == np.inf:
            return count, False
    row[VELOCITY:ACCELERATION] = 0.0
    row[ANGULAR:VERTICAL_SPIN] = 0.0
    return count, True


@compiled
def come_to_rest(
    surface: Surface, row: NDArray[np.float64], segments: NDArray[np.float64], count: int
) -> tuple[int, bool]:
    """Follow a ball that lies on the cloth to the end; return as `slide` does."""
    count, ends = slide(surface, row, segments, count)
    if ends:
        count, ends = roll(surface, row, segments, count)
    if ends and row[VERTICAL_SPIN] != 0.0:
        ends = surface.spin_deceleration > 0.0
        duration = abs(row[VERTICAL_SPIN]) / surface.spin_deceleration
        count = follow_spinning(surface, row, SPIN, duration, segments, count)
        if ends:
            row[VERTICAL_SPIN] = 0.0
    if ends:
        count = follow(row, REST, np.inf, segments, count)
    return count, ends
