"""
When a lying ball meets something of the table: a nose, a facing, an arc, a hole.

What it meets is a number: a nose (+x, -x, +y, -y), then the 12 facings, the 12 arcs, the 6 holes
(see furniture.py), or OUTSIDE.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.first_contact import first_contact, PRESSED, STILL, TOUCH
from billiard_shot.table.furniture import Bed, POCKETS
from billiard_shot.table.motion import ACCELERATION, END, POSITION, TIME, VELOCITY

BEYOND = 1e-8  # m: a ball that is deeper than that in a nose is in a mouth, beside it
NOTHING = -1
NOSES, FACINGS, ARCS, HOLES, OUTSIDE = 0, 4, 16, 28, 34


@fused
def crossing(gap: float, speed: float, half: float) -> float:
    """
    When gap - speed t - half t^2 goes from positive to negative: the one such t >= 0, or inf.

    As in `first_contact`, one that is over does not count, nor one without any speed.
    """
    if gap <= TOUCH:
        if gap > -BEYOND:
            if abs(speed) <= STILL:
                gap = max(gap + PRESSED, 0.1 * PRESSED)
            elif speed > 0.0:
                return 0.0
            else:
                gap = 0.0
        elif speed > 0.0:
            return np.inf
    root = speed * speed + 4.0 * half * gap
    if root < 0.0 or (speed <= 0.0 and half <= 0.0):
        return np.inf
    root = np.sqrt(root)
    return 2.0 * gap / (speed + root) if speed > 0.0 else (root - speed) / (2.0 * half)


@fused
def span(x: float, v: float, a: float, t: float) -> tuple[float, float]:
    """Least and largest x + v s + a s^2 / 2 for s from 0 to t."""
    end = x + (v + 0.5 * a * t) * t
    low, high = min(x, end), max(x, end)
    if v * a < 0.0 and -v / a < t:
        turn = x - 0.5 * v * v / a
        low, high = min(low, turn), max(high, turn)
    return low, high


@fused
def reach_circle(
    ball: NDArray[np.float64], x: float, y: float, radius: float, end: float
) -> float:
    """Time from now until the ball's centre comes within a radius of (x, y), if before `end`."""
    dx, dy = ball[POSITION] - x, ball[POSITION + 1] - y
    u, v = ball[VELOCITY], ball[VELOCITY + 1]
    f, g = 0.5 * ball[ACCELERATION], 0.5 * ball[ACCELERATION + 1]
    return first_contact(
        dx * dx + dy * dy - radius * radius, 2.0 * (dx * u + dy * v),
        u * u + v * v + 2.0 * (dx * f + dy * g), 2.0 * (u * f + v * g), f * f + g * g,
        end, 2.0 * radius,
    )


@fused
def reach_facing(ball: NDArray[np.float64], bed: Bed, jaw: int) -> float:
    """Time from now until a lying ball meets a facing."""
    f = bed.facings[jaw]
    dx, dy = ball[POSITION] - f[0], ball[POSITION + 1] - f[1]
    speed = -(ball[VELOCITY] * f[4] + ball[VELOCITY + 1] * f[5])
    half = -0.5 * (ball[ACCELERATION] * f[4] + ball[ACCELERATION + 1] * f[5])
    t = crossing(dx * f[4] + dy * f[5] - bed.reach, speed, half)
    if t == np.inf:
        return t
    dx += (ball[VELOCITY] + 0.5 * ball[ACCELERATION] * t) * t
    dy += (ball[VELOCITY + 1] + 0.5 * ball[ACCELERATION + 1] * t) * t
    lx, ly = f[2] - f[0], f[3] - f[1]
    along = dx * lx + dy * ly
    return t if 0.0 <= along <= lx * lx + ly * ly else np.inf


@fused
def on_nose(bed: Bed, nose: int, x: float, y: float) -> bool:
    """Whether a ball at (x, y) is beside the straight part of a nose."""
    if bed.corner_end == 0.0:
        return True
    if nose < 2:
        return abs(y) <= bed.y + bed.reach - bed.corner_end
    return bed.side_end <= abs(x) <= bed.x + bed.reach - bed.corner_end


@fused
def next_of_table(
    bed: Bed, depth: float, ball: NDArray[np.float64]
) -> tuple[float, int, int]:
    """
    When a lying ball meets something of the table before its motion ends, and what.

    And in how many pockets that was looked for: those whose box the ball's path may enter.
    """
    px, py, vx, vy = ball[POSITION], ball[POSITION + 1], ball[VELOCITY], ball[VELOCITY + 1]
    ax, ay = ball[ACCELERATION], ball[ACCELERATION + 1]
    end, what, looked = ball[END] - ball[TIME], NOTHING, 0
    if vx == 0.0 and vy == 0.0 and ax == 0.0 and ay == 0.0:
        return np.inf, what, looked
    for nose in range(4):
        sign = 1.0 if nose % 2 == 0 else -1.0
        if nose < 2:
            t = crossing(bed.x - sign * px, sign * vx, 0.5 * sign * ax)
        else:
            t = crossing(bed.y - sign * py, sign * vy, 0.5 * sign * ay)
        if t < end and on_nose(
            bed, nose, px + (vx + 0.5 * ax * t) * t, py + (vy + 0.5 * ay * t) * t
        ):
            end, what = t, nose
    if bed.corner_end > 0.0:
        low_x, high_x = span(px, vx, ax, min(end, 1e5))
        low_y, high_y = span(py, vy, ay, min(end, 1e5))
        for pocket in range(POCKETS):
            box = bed.boxes[pocket]
            if (low_x > box[0] + box[2] or high_x < box[0] - box[2]
                    or low_y > box[1] + box[3] or high_y < box[1] - box[3]):
                continue
            looked += 1
            for jaw in range(2 * pocket, 2 * pocket + 2):
                t = reach_facing(ball, bed, jaw)
                if t < end:
                    end, what = t, FACINGS + jaw
                arc = bed.arcs[jaw]
                t = reach_circle(ball, arc[0], arc[1], arc[2] + bed.reach, end)
                if t < end:
                    end, what = t, ARCS + jaw
            hole = bed.holes[pocket]
            t = reach_circle(ball, hole[0], hole[1], hole[2], end)
            if t < end:
                end, what = t, HOLES + pocket
        if what == NOTHING:
            for side in (1.0, -1.0):
                t = min(
                    crossing(bed.x + bed.reach + depth - side * px, side * vx, 0.5 * side * ax),
                    crossing(bed.y + bed.reach + depth - side * py, side * vy, 0.5 * side * ay),
                )
                if t < end:
                    end, what = t, OUTSIDE
    return (ball[TIME] + end if what != NOTHING else np.inf), what, looked
