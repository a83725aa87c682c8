"""When a ball meets something of the table: noses, facings, arcs, holes; lying or in the air."""

import math

from billiard_shot.compiled import inner, innermost
from billiard_shot.numerics.polynomial import first_quartic_root
from billiard_shot.table.model.geometry import (
    Jaw,
    PocketGeometry,
    POCKETS,
    TableModel,
    TableNumbers,
)
from billiard_shot.table.model.motion import BallRecord, NOTHING

HORIZON = 1e3  # s: as far as endless motions are looked at; 1e-7 of it is the shortest contact
TOUCH_GAP = 1e-10  # m
PRESSED_GAP = 5e-10  # m
MIN_CLOSING_SPEED = 1e-5  # m/s


@inner
def contact_time(
    a: float, b: float, c: float, d: float, e: float, end: float, scale: float
) -> float:
    """
    When a gap a + b t + c t^2 + d t^3 + e t^4 closes: the first such time in [0, end], or inf.

    `scale` is the polynomial's value per metre of the gap. Bodies within TOUCH_GAP of each other
    touch. If they part, the contact that is over is divided out. If they approach, they meet at
    once. If they do neither (below MIN_CLOSING_SPEED), they meet when they are pressed together by
    PRESSED_GAP.
    """
    if a <= TOUCH_GAP * scale:
        if b < -MIN_CLOSING_SPEED * scale:
            return 0.0
        if b > MIN_CLOSING_SPEED * scale:
            a, b, c, d, e = b, c, d, e, 0.0
        else:
            a = max(a + PRESSED_GAP * scale, 0.1 * PRESSED_GAP * scale)
    span = min(end, HORIZON)
    square = span * span
    return span * first_quartic_root(
        a, b * span, c * square, d * square * span, e * square * square
    )


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


MAX_FLIGHT_STEPS = 2000
NEAR_EDGE = 1e-12  # m
SKIP = 1e-5  # s: how long a ball that just left an edge is not looked at


@inner
def edge_at(table: TableModel, feature: int, x: float, y: float) -> tuple[float, float, float]:
    """Horizontal direction from an edge to a point, and its distance, negative behind the edge."""
    if feature < FACINGS:
        sign = 1.0 if feature % 2 == 0 else -1.0
        if feature < 2:
            return -sign, 0.0, table.numbers.nose_half_length - sign * x
        return 0.0, -sign, table.numbers.nose_half_width - sign * y
    if feature < ARCS:
        jaw = table.jaws[feature - FACINGS]
        away = (x - jaw.start_x) * jaw.normal_x + (y - jaw.start_y) * jaw.normal_y
        return jaw.normal_x, jaw.normal_y, away
    jaw = table.jaws[feature - ARCS]
    dx, dy = x - jaw.arc_x, y - jaw.arc_y
    distance = math.sqrt(dx * dx + dy * dy)
    if distance == 0.0:
        return 1.0, 0.0, -jaw.arc_radius
    return dx / distance, dy / distance, distance - jaw.arc_radius


@inner
def projects_onto_edge(table: TableModel, feature: int, x: float, y: float) -> bool:
    """Whether the point of an edge that is nearest to (x, y) belongs to it."""
    if feature < FACINGS:
        return beside_nose(table.numbers, feature, x, y)
    if feature < ARCS:
        jaw = table.jaws[feature - FACINGS]
        lx, ly = jaw.end_x - jaw.start_x, jaw.end_y - jaw.start_y
        along = (x - jaw.start_x) * lx + (y - jaw.start_y) * ly
        return 0.0 <= along <= lx * lx + ly * ly
    return True


@inner
def reach_line(table: TableModel, ball: BallRecord, feature: int, end: float) -> float:
    """Time until a ball in the air touches the line of a straight edge, up to `end`; else inf."""
    radius, climb, half = table.params.radius, ball.velocity[2], 0.5 * ball.acceleration[2]
    x, y, away = edge_at(table, feature, ball.position[0], ball.position[1])
    coming = x * ball.velocity[0] + y * ball.velocity[1]
    above = ball.position[2] - table.numbers.nose_height
    return contact_time(
        away * away + above * above - radius * radius,
        2.0 * (away * coming + above * climb),
        coming * coming + climb * climb + 2.0 * above * half,
        2.0 * climb * half,
        half * half,
        end,
        scale=2.0 * radius,
    )


@inner
def reach_edge(table: TableModel, ball: BallRecord, feature: int, end: float) -> float:
    """Time from now until a ball in the air touches an edge, if before `end`; else inf."""
    radius, height = table.params.radius, table.numbers.nose_height
    px, py, pz = ball.position[0], ball.position[1], ball.position[2]
    vx, vy, climb = ball.velocity[0], ball.velocity[1], ball.velocity[2]
    az = ball.acceleration[2]
    fall = climb + az * end
    fastest = math.sqrt(vx * vx + vy * vy + max(climb * climb, fall * fall)) + 1e-9
    t = 0.0
    if feature < ARCS:
        t = reach_line(table, ball, feature, end)
        if t > end or projects_onto_edge(table, feature, px + vx * t, py + vy * t):
            return t
    for _ in range(MAX_FLIGHT_STEPS):
        x, y = px + vx * t, py + vy * t
        z = pz + (climb + 0.5 * az * t) * t - height
        nx, ny, away = edge_at(table, feature, x, y)
        distance = math.sqrt(away * away + z * z)
        gap = distance - radius
        if gap <= TOUCH_GAP:
            speed = away * (nx * vx + ny * vy) + z * (climb + az * t)
            least = MIN_CLOSING_SPEED if t == 0.0 else 0.0
            closing = distance > 0.0 and -speed / distance > least
            if closing and projects_onto_edge(table, feature, x, y):
                return t
            t += SKIP
        else:
            t += max(gap - NEAR_EDGE, 0.5 * NEAR_EDGE) / fastest
        if t > end:
            break
    return math.inf


@inner
def next_flight_boundary(table: TableModel, ball: BallRecord) -> tuple[float, int]:
    """When a ball in the air meets something of the table before it lands, and what."""
    n, radius = table.numbers, table.params.radius
    end, feature = ball.end - ball.time, NOTHING
    px, py, vx, vy = ball.position[0], ball.position[1], ball.velocity[0], ball.velocity[1]
    t = leaving_time(n, ball)
    if t < end:
        end, feature = t, OUTSIDE
    clearance = min(
        n.nose_half_length - max(abs(px), abs(px + vx * end)),
        n.nose_half_width - max(abs(py), abs(py + vy * end)),
    )
    for edge in range(4 if clearance <= radius else 0):
        t = reach_edge(table, ball, edge, end)
        if t < end:
            end, feature = t, edge
    # A ball in the air is wider at the height of the noses than one that lies.
    low_x, high_x = coordinate_range(px, vx, 0.0, end)
    low_y, high_y = coordinate_range(py, vy, 0.0, end)
    wider = radius - n.nose_standoff
    for index in range(POCKETS if n.corner_end > 0.0 else 0):
        if may_enter(
            table.pockets[index], low_x - wider, high_x + wider, low_y - wider, high_y + wider
        ):
            end, feature = fly_into_pocket(table, ball, index, end, feature)
    return (ball.time + end if feature != NOTHING else math.inf), feature


@inner
def fly_into_pocket(
    table: TableModel, ball: BallRecord, index: int, end: float, feature: int
) -> tuple[float, int]:
    """Time from now until a ball in the air meets anything of a pocket, if before `end`."""
    for jaw in range(2 * index, 2 * index + 2):
        t = reach_edge(table, ball, FACINGS + jaw, end)
        if t < end:
            end, feature = t, FACINGS + jaw
        t = reach_edge(table, ball, ARCS + jaw, end)
        if t < end:
            end, feature = t, ARCS + jaw
    capture_height = table.numbers.nose_height + table.params.radius
    t = pocket_drop_time(table.pockets[index], capture_height, ball, end)
    if t < end:
        end, feature = t, HOLES + index
    return end, feature


@inner
def pocket_drop_time(
    pocket: PocketGeometry, capture_height: float, ball: BallRecord, end: float
) -> float:
    """Time from now until a ball is over a hole and its centre not above a height; or inf."""
    dx, dy = ball.position[0] - pocket.hole_x, ball.position[1] - pocket.hole_y
    height = ball.position[2]
    vx, vy, climb = ball.velocity[0], ball.velocity[1], ball.velocity[2]
    gravity = -ball.acceleration[2]
    a, b = vx * vx + vy * vy, dx * vx + dy * vy
    c = dx * dx + dy * dy - pocket.hole_radius * pocket.hole_radius
    square = b * b - a * c
    begin, leave = 0.0, math.inf
    if square > 0.0 and a != 0.0:
        root = math.sqrt(square)
        begin, leave = max((-b - root) / a, 0.0), (-b + root) / a
    elif c > 0.0:
        return math.inf
    leave = min(leave, end)
    if begin >= leave:
        return math.inf
    # low at the beginning, or coming down to that height before it has left
    if height + (climb - 0.5 * gravity * begin) * begin <= capture_height:
        return begin
    if gravity <= 0.0:
        return math.inf
    fall = max(climb * climb + 2.0 * gravity * (height - capture_height), 0.0)
    down = (climb + math.sqrt(fall)) / gravity
    return down if begin <= down <= leave else math.inf


@inner
def lands_off_table(table: TableModel, ball: BallRecord) -> bool:
    """Whether a ball that comes down lands neither on the bed nor on the shelf of a pocket."""
    n, x, y = table.numbers, ball.position[0], ball.position[1]
    if abs(x) <= n.nose_half_length and abs(y) <= n.nose_half_width:
        return False
    for index in range(POCKETS if n.corner_end > 0.0 else 0):
        pocket = table.pockets[index]
        if (x - pocket.hole_x) * pocket.hole_x + (y - pocket.hole_y) * pocket.hole_y >= 0.0:
            continue  # behind the hole
        if (
            edge_at(table, FACINGS + 2 * index, x, y)[2] > 0.0
            and edge_at(table, FACINGS + 2 * index + 1, x, y)[2] > 0.0
            and may_enter(pocket, x, x, y, y)
        ):
            return False
    return True
