"""
When a ball in the air meets something of the table, or flies over it.

The noses are edges at their height. The square of the distance from a straight edge is a
polynomial in time. If the ball touches the line beyond the end of the edge, or if the edge is an
arc, the search goes on in steps: the distance changes no faster than the ball moves, and the steps
take the time that it leaves. That is slow if a ball comes close without touching, but few balls
fly, and not for long.
"""

import math

from billiard_shot.compiled import inner
from billiard_shot.table.contact_time import contact_time, MIN_CLOSING_SPEED, TOUCH_GAP
from billiard_shot.table.geometry import PocketGeometry, POCKETS, TableModel
from billiard_shot.table.motion import BallRecord, NOTHING
from billiard_shot.table.rolling_boundary import (
    ARCS,
    beside_nose,
    coordinate_range,
    FACINGS,
    HOLES,
    leaving_time,
    may_enter,
    OUTSIDE,
)

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
