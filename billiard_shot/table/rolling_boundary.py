"""
When a lying ball meets something of the table: a nose, a facing, an arc, a hole.

What it meets is a number, its feature: a nose (+x, -x, +y, -y), then the 12 facings, the 12 arcs,
the 6 holes (see geometry.py), or OUTSIDE; or NOTHING.
"""

import math

from billiard_shot.compiled import inner, innermost
from billiard_shot.table.contact_time import (
    contact_time,
    HORIZON,
    MIN_CLOSING_SPEED,
    PRESSED_GAP,
    TOUCH_GAP,
)
from billiard_shot.table.geometry import Jaw, PocketGeometry, POCKETS, TableModel, TableNumbers
from billiard_shot.table.motion import BallRecord, NOTHING

DEPTH_IN_MOUTH = 1e-8  # m: a ball that is deeper than that in a nose is in a mouth, beside it
FACINGS, ARCS, HOLES, OUTSIDE = 4, 16, 28, 34


@inner
def crossing_time(gap: float, speed: float, half: float) -> float:
    """
    When gap - speed t - half t^2 goes from positive to negative: the one such t >= 0, or inf.

    As in `contact_time`, a crossing that is over does not count, nor one without any speed.
    """
    if gap <= TOUCH_GAP:
        if gap > -DEPTH_IN_MOUTH:
            if abs(speed) <= MIN_CLOSING_SPEED:
                gap = max(gap + PRESSED_GAP, 0.1 * PRESSED_GAP)
            elif speed > 0.0:
                return 0.0
            else:
                gap = 0.0
        elif speed > 0.0:
            return math.inf
    root = speed * speed + 4.0 * half * gap
    if root < 0.0 or (speed <= 0.0 and half <= 0.0):
        return math.inf
    root = math.sqrt(root)
    return 2.0 * gap / (speed + root) if speed > 0.0 else (root - speed) / (2.0 * half)


@inner
def coordinate_range(x: float, v: float, a: float, t: float) -> tuple[float, float]:
    """Least and largest x + v s + a s^2 / 2 for s from 0 to t."""
    end = x + (v + 0.5 * a * t) * t
    low, high = min(x, end), max(x, end)
    if v * a < 0.0 and -v / a < t:
        turn = x - 0.5 * v * v / a
        low, high = min(low, turn), max(high, turn)
    return low, high


@inner
def reach_circle(ball: BallRecord, x: float, y: float, radius: float, end: float) -> float:
    """Time from now until the ball's centre comes within a radius of (x, y), if before `end`."""
    dx, dy = ball.position[0] - x, ball.position[1] - y
    u, v = ball.velocity[0], ball.velocity[1]
    f, g = 0.5 * ball.acceleration[0], 0.5 * ball.acceleration[1]
    return contact_time(
        dx * dx + dy * dy - radius * radius,
        2.0 * (dx * u + dy * v),
        u * u + v * v + 2.0 * (dx * f + dy * g),
        2.0 * (u * f + v * g),
        f * f + g * g,
        end,
        scale=2.0 * radius,
    )


@inner
def reach_facing(ball: BallRecord, jaw: Jaw, standoff: float) -> float:
    """Time from now until a lying ball meets a facing."""
    dx, dy = ball.position[0] - jaw.start_x, ball.position[1] - jaw.start_y
    u, v, nx, ny = ball.velocity[0], ball.velocity[1], jaw.normal_x, jaw.normal_y
    f, g = ball.acceleration[0], ball.acceleration[1]
    t = crossing_time(dx * nx + dy * ny - standoff, -(u * nx + v * ny), -0.5 * (f * nx + g * ny))
    if t == math.inf:
        return t
    dx += (u + 0.5 * f * t) * t
    dy += (v + 0.5 * g * t) * t
    lx, ly = jaw.end_x - jaw.start_x, jaw.end_y - jaw.start_y
    along = dx * lx + dy * ly
    return t if 0.0 <= along <= lx * lx + ly * ly else math.inf


@innermost
def beside_nose(n: TableNumbers, nose: int, x: float, y: float) -> bool:
    """Whether a ball at (x, y) is beside the straight part of a nose."""
    if n.corner_end == 0.0:
        return True
    if nose < 2:
        return abs(y) <= n.nose_half_width - n.corner_end
    return n.side_end <= abs(x) <= n.nose_half_length - n.corner_end


@innermost
def approach_to_nose(n: TableNumbers, nose: int, ball: BallRecord) -> tuple[float, float, float]:
    """Find a ball's gap to a nose [m], and its speed and half its acceleration towards it."""
    sign = 1.0 if nose % 2 == 0 else -1.0
    p, v, a = ball.position, ball.velocity, ball.acceleration
    if nose < 2:
        return n.centre_half_length - sign * p[0], sign * v[0], 0.5 * sign * a[0]
    return n.centre_half_width - sign * p[1], sign * v[1], 0.5 * sign * a[1]


@inner
def reach_nose(n: TableNumbers, nose: int, ball: BallRecord) -> float:
    """
    Time from now until a lying ball meets the line of a nose, or inf.

    If another ball has ended the contact of this ball with the nose, this ball lies in the nose.
    It then meets the nose at once, unless it is leaving the nose.
    """
    gap, speed, half = approach_to_nose(n, nose, ball)
    if gap <= -DEPTH_IN_MOUTH and beside_nose(n, nose, ball.position[0], ball.position[1]):
        leaves = speed < -MIN_CLOSING_SPEED and speed * speed + 4.0 * half * gap > 0.0
        gap = gap if leaves else 0.0
    return crossing_time(gap, speed, half)


@innermost
def may_enter(
    pocket: PocketGeometry, low_x: float, high_x: float, low_y: float, high_y: float
) -> bool:
    """Whether a path within a rectangle may meet anything of a pocket."""
    x, y = pocket.bounds_x, pocket.bounds_y
    half_length, half_width = pocket.bounds_half_length, pocket.bounds_half_width
    return not (
        low_x > x + half_length
        or high_x < x - half_length
        or low_y > y + half_width
        or high_y < y - half_width
    )


@inner
def reach_pocket(
    table: TableModel, ball: BallRecord, index: int, end: float, feature: int
) -> tuple[float, int]:
    """Time from now until a lying ball meets anything of a pocket, and what, if before `end`."""
    standoff = table.numbers.nose_standoff
    for i in range(2 * index, 2 * index + 2):
        jaw = table.jaws[i]
        t = reach_facing(ball, jaw, standoff)
        if t < end:
            end, feature = t, FACINGS + i
        t = reach_circle(ball, jaw.arc_x, jaw.arc_y, jaw.arc_radius + standoff, end)
        if t < end:
            end, feature = t, ARCS + i
    pocket = table.pockets[index]
    t = reach_circle(ball, pocket.hole_x, pocket.hole_y, pocket.hole_radius, end)
    if t < end:
        end, feature = t, HOLES + index
    return end, feature


@inner
def leaving_time(n: TableNumbers, ball: BallRecord) -> float:
    """Time from now until a ball's centre is behind the cushions, or inf."""
    first = math.inf
    for side in (1.0, -1.0):
        for i in range(2):
            noses = n.nose_half_length if i == 0 else n.nose_half_width
            gap = noses + n.cushion_depth - side * ball.position[i]
            half = 0.5 * side * ball.acceleration[i]
            first = min(first, crossing_time(gap, side * ball.velocity[i], half))
    return first


@inner
def next_rolling_boundary(table: TableModel, ball: BallRecord) -> tuple[float, int, int]:
    """
    When a lying ball meets something of the table before its segment ends, and what.

    And in how many pockets that was looked for: those whose bounds the ball's path may enter.
    """
    n = table.numbers
    px, py, vx, vy = ball.position[0], ball.position[1], ball.velocity[0], ball.velocity[1]
    ax, ay = ball.acceleration[0], ball.acceleration[1]
    end, feature, searched = ball.end - ball.time, NOTHING, 0
    if vx == 0.0 and vy == 0.0 and ax == 0.0 and ay == 0.0:
        return math.inf, feature, searched
    for nose in range(4):
        t = reach_nose(n, nose, ball)
        if t < end and beside_nose(
            n, nose, px + (vx + 0.5 * ax * t) * t, py + (vy + 0.5 * ay * t) * t
        ):
            end, feature = t, nose
    if n.corner_end > 0.0:
        low_x, high_x = coordinate_range(px, vx, ax, min(end, HORIZON))
        low_y, high_y = coordinate_range(py, vy, ay, min(end, HORIZON))
        for index in range(POCKETS):
            if may_enter(table.pockets[index], low_x, high_x, low_y, high_y):
                searched += 1
                end, feature = reach_pocket(table, ball, index, end, feature)
        if feature == NOTHING:
            t = leaving_time(n, ball)
            if t < end:
                end, feature = t, OUTSIDE
    return (ball.time + end if feature != NOTHING else math.inf), feature, searched
