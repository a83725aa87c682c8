"""
When a ball in the air meets something of the table, or flies over it.

The noses are edges at their height. How far the ball's centre is from an edge changes no faster
than the ball moves, so that one may go on by that time, again and again, and miss nothing; that is
slow where a ball comes close without touching, but few balls fly, and not for long.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.first_contact import STILL, TOUCH
from billiard_shot.table.furniture import Bed, Furniture, POCKETS
from billiard_shot.table.motion import (
    ACCELERATION,
    CLIMB,
    END,
    HEIGHT,
    POSITION,
    TIME,
    VELOCITY,
)
from billiard_shot.table.rails import ARCS, crossing, FACINGS, HOLES, NOTHING, on_nose, OUTSIDE

STEPS = 2000
NEAR = 1e-12  # m
SKIP = 1e-5  # s: how long a ball that just left an edge is not looked at


@fused
def edge_at(
    bed: Bed, what: int, x: float, y: float
) -> tuple[float, float, float]:
    """Horizontal direction from an edge to a point, and its distance, negative behind the edge."""
    if what < FACINGS:
        sign = 1.0 if what % 2 == 0 else -1.0
        if what < 2:
            return -sign, 0.0, bed.x + bed.reach - sign * x
        return 0.0, -sign, bed.y + bed.reach - sign * y
    if what < ARCS:
        f = bed.facings[what - FACINGS]
        return f[4], f[5], (x - f[0]) * f[4] + (y - f[1]) * f[5]
    arc = bed.arcs[what - ARCS]
    dx, dy = x - arc[0], y - arc[1]
    distance = np.sqrt(dx * dx + dy * dy)
    return dx / distance, dy / distance, distance - arc[2]


@fused
def beside(bed: Bed, what: int, x: float, y: float) -> bool:
    """Whether the point of an edge that is nearest to (x, y) belongs to it."""
    if what < FACINGS:
        return on_nose(bed, what, x, y)
    if what < ARCS:
        f = bed.facings[what - FACINGS]
        lx, ly = f[2] - f[0], f[3] - f[1]
        return bool(0.0 <= (x - f[0]) * lx + (y - f[1]) * ly <= lx * lx + ly * ly)
    return True


@fused
def reach_edge(
    bed: Bed, height: float, radius: float, ball: NDArray[np.float64], what: int, end: float
) -> float:
    """Time from now until a ball in the air touches an edge, if before `end`; else inf."""
    vx, vy, climb = ball[VELOCITY], ball[VELOCITY + 1], ball[CLIMB]
    fall = climb + ball[ACCELERATION + 2] * end
    fastest = np.sqrt(vx * vx + vy * vy + max(climb * climb, fall * fall)) + 1e-9
    t = 0.0
    for _ in range(STEPS):
        x, y = ball[POSITION] + vx * t, ball[POSITION + 1] + vy * t
        z = ball[HEIGHT] + (climb + 0.5 * ball[ACCELERATION + 2] * t) * t - height
        nx, ny, away = edge_at(bed, what, x, y)
        distance = np.sqrt(away * away + z * z)
        gap = distance - radius
        if gap <= TOUCH:
            speed = (away * (nx * vx + ny * vy) + z * (climb + ball[ACCELERATION + 2] * t))
            closing = -speed / distance > (STILL if t == 0.0 else 0.0)
            if closing and beside(bed, what, x, y):
                return t
            t += SKIP
        else:
            t += max(gap - NEAR, 0.5 * NEAR) / fastest
        if t > end:
            break
    return np.inf


@fused
def next_of_flight(
    bed: Bed, furniture: Furniture, radius: float, ball: NDArray[np.float64]
) -> tuple[float, int]:
    """When a ball in the air meets something of the table before it lands, and what."""
    end, what = ball[END] - ball[TIME], NOTHING
    px, py, vx, vy = ball[POSITION], ball[POSITION + 1], ball[VELOCITY], ball[VELOCITY + 1]
    half_x, half_y = bed.x + bed.reach, bed.y + bed.reach
    for side in (1.0, -1.0):
        t = min(
            crossing(half_x + furniture.depth - side * px, side * vx, 0.0),
            crossing(half_y + furniture.depth - side * py, side * vy, 0.0),
        )
        if t < end:
            end, what = t, OUTSIDE
    room = min(
        half_x - max(abs(px), abs(px + vx * end)), half_y - max(abs(py), abs(py + vy * end))
    )
    if room > radius and bed.corner_end == 0.0:
        return (ball[TIME] + end if what != NOTHING else np.inf), what
    for edge in range(4 if bed.corner_end == 0.0 else HOLES):
        t = reach_edge(bed, furniture.height, radius, ball, edge, end)
        if t < end:
            end, what = t, edge
    for pocket in range(POCKETS if bed.corner_end > 0.0 else 0):
        t = drop(bed, furniture.height + radius, ball, pocket, end)
        if t < end:
            end, what = t, HOLES + pocket
    return (ball[TIME] + end if what != NOTHING else np.inf), what


@fused
def drop(
    bed: Bed, lid: float, ball: NDArray[np.float64], pocket: int, end: float
) -> float:
    """Time from now until a ball is over a hole and its centre not above a height; or inf."""
    dx, dy = ball[POSITION] - bed.holes[pocket, 0], ball[POSITION + 1] - bed.holes[pocket, 1]
    vx, vy, climb = ball[VELOCITY], ball[VELOCITY + 1], ball[CLIMB]
    gravity = -ball[ACCELERATION + 2]
    a, b = vx * vx + vy * vy, dx * vx + dy * vy
    c = dx * dx + dy * dy - bed.holes[pocket, 2] ** 2
    root = b * b - a * c
    if root <= 0.0 or a == 0.0:
        begin, leave = (0.0, np.inf) if c <= 0.0 else (np.inf, np.inf)
    else:
        begin, leave = (-b - np.sqrt(root)) / a, (-b + np.sqrt(root)) / a
    begin, leave = max(begin, 0.0), min(leave, end)
    if begin >= leave:
        return np.inf
    # low at the beginning, or coming down to the lid before it has left
    if ball[HEIGHT] + (climb - 0.5 * gravity * begin) * begin <= lid:
        return begin
    down = (climb + np.sqrt(max(climb * climb + 2.0 * gravity * (ball[HEIGHT] - lid), 0.0))
            ) / gravity if gravity > 0.0 else np.inf
    return down if begin <= down <= leave else np.inf


@fused
def off_bed(bed: Bed, ball: NDArray[np.float64]) -> bool:
    """Whether a ball is behind the line of noses: where it lands is not the bed."""
    return bool(
        abs(ball[POSITION]) > bed.x + bed.reach or abs(ball[POSITION + 1]) > bed.y + bed.reach
    )
