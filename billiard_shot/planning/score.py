"""
Penalties of simulated strokes: how far they are from reaching the target.

Each missing step towards the target costs `PENALTY_STEP`. The remaining distance [m] is added; it
is less than a step, so that a stroke that misses fewer steps has the smaller penalty. Paths are
approximated by straight lines, `PENALTY_PIECES` to a segment.
"""

from enum import IntEnum
import math
from typing import Any, NamedTuple

from billiard_shot.compiled import entry, inner
from billiard_shot.records import Floats, record, Storage
from billiard_shot.table.model.geometry import POCKETS
from billiard_shot.table.model.motion import (
    BALL,
    BallRule,
    CLUSTER,
    LEFT_TABLE,
    NOTHING,
    POCKETED,
    RELEASE,
    SegmentRecord,
)
from billiard_shot.table.run.play_tables import BallOutcome, TableOutcome

PENALTY_STEP = 1.0
MAX_DISTANCE_PENALTY = 0.99
NO_SUCCESS = 1e-6  # m: smallest penalty of a target that was not reached
PENALTY_PIECES = 6
NO_DISTANCE = 1e3  # m: stands for "no distance"


class GoalKind(IntEnum):
    """Kind of a goal; the classes of targets.py."""

    REST = 0
    PASS = 1
    GATE = 2
    HIT = 3
    HIT_DIRECTION = 4
    HIT_AT = 5
    POT = 6
    POT_AND_LEAVE = 7
    FOULS = 8  # only fouls count here; runner.py adds the rest


TO_REST, PASS, GATE, HIT, HIT_DIRECTION, HIT_AT, POT, POT_AND_LEAVE, FOULS = map(int, GoalKind)


@record
class Goal:
    """A target in numbers."""

    kind: int  # Kind
    x: float  # m: the point, the first end of the gate, or the direction
    y: float
    u: float  # m: the second end of the gate
    v: float
    radius: float  # m, around the point; rad, of the direction
    ball: int  # to be hit
    must_meet: bool  # a stroke without a collision is a foul
    ball_radius: float  # m


class Objective(NamedTuple):
    """The target of strokes on a table with n balls."""

    goals: list[Goal]  # 1
    rules: list[BallRule]  # n
    wanted: Floats  # (n, POCKETS) above 0 if the ball may fall there to reach the target
    places: Floats  # (n, 2) m, of the balls at first
    holes: Floats  # (POCKETS, 2) m, of the holes of pockets


class Runs(NamedTuple):
    """Recorded runs of tables with n balls, and scratch."""

    balls: list[BallOutcome]  # tables n
    tables: list[TableOutcome]
    segments: list[SegmentRecord]
    ends: Floats  # (segments,) scratch, see `write_ends`
    following: Floats  # (n,) scratch


class RunPart(NamedTuple):
    """The part of `Runs` that belongs to one table."""

    first: int  # of its balls
    begin: int  # its segments are those from here
    end: int  # up to here


@inner
def distance_penalty(gap: float) -> float:
    """Penalty of a distance [m] that is missing."""
    return min(max(gap, 0.0), MAX_DISTANCE_PENALTY)


@inner
def piece_distance(px: float, py: float, qx: float, qy: float) -> float:
    """Square of the distance [m^2] between the origin and the line from p to q."""
    dx, dy = qx - px, qy - py
    square = dx * dx + dy * dy
    part = 0.0
    if square > 0.0:
        part = min(max(-(px * dx + py * dy) / square, 0.0), 1.0)
    x, y = px + part * dx, py + part * dy
    return x * x + y * y


@inner
def nearest(segment: SegmentRecord, lasting: float, x: float, y: float, least: float) -> float:
    """
    Smallest horizontal distance [m] between a point and a segment of this duration [s].

    Or `least`, which is what counts if the segment does not come as near as that.
    """
    p, v, a = segment.position, segment.velocity, segment.acceleration
    px, py = p[0] - x, p[1] - y
    square = px * px + py * py
    if lasting <= 0.0:
        return min(math.sqrt(square), least)
    speed = math.sqrt(v[0] * v[0] + v[1] * v[1])
    gain = 0.5 * lasting * math.sqrt(a[0] * a[0] + a[1] * a[1])
    if math.sqrt(square) - lasting * (speed + gain) >= least:
        return least
    for i in range(1, PENALTY_PIECES + 1):
        t = lasting * i / PENALTY_PIECES
        qx = p[0] - x + t * (v[0] + 0.5 * t * a[0])
        qy = p[1] - y + t * (v[1] + 0.5 * t * a[1])
        square = min(square, piece_distance(px, py, qx, qy))
        px, py = qx, qy
    return min(math.sqrt(square), least)


@inner
def crosses(segment: SegmentRecord, lasting: float, goal: Goal) -> bool:
    """Whether a segment crosses the line between the ends of a gate."""
    p, v, a = segment.position, segment.velocity, segment.acceleration
    lx, ly = goal.u - goal.x, goal.v - goal.y
    px, py = p[0] - goal.x, p[1] - goal.y
    for i in range(1, PENALTY_PIECES + 1):
        t = lasting * i / PENALTY_PIECES
        qx = p[0] - goal.x + t * (v[0] + 0.5 * t * a[0])
        qy = p[1] - goal.y + t * (v[1] + 0.5 * t * a[1])
        one, two = lx * py - ly * px, lx * qy - ly * qx
        if one * two <= 0.0 and one != two:
            part = one / (one - two)
            along = (px + part * (qx - px)) * lx + (py + part * (qy - py)) * ly
            if 0.0 <= along <= lx * lx + ly * ly:
                return True
        px, py = qx, qy
    return False


@inner
def is_foul(sought: Objective, table: TableOutcome, balls: list[BallOutcome], first: int) -> bool:
    """
    Whether a ball left the table, one that must stay fell, or the wrong ball was met first.

    Also whether the cue hit the cue ball twice (WPA, Rules of Play, 6.7).
    """
    rules = sought.rules
    if table.double_hit:
        return True
    for i in range(len(rules)):
        motion = balls[first + i].motion
        if motion == LEFT_TABLE or (motion == POCKETED and rules[i].must_stay):
            return True
    met = balls[first].first_contact
    if met == NOTHING:
        return sought.goals[0].must_meet
    return rules[met].barred


@inner
def has_hit(segment: SegmentRecord) -> bool:
    """Whether a segment starts with a collision of balls."""
    return (segment.cause == BALL or segment.cause == CLUSTER) and segment.motion < POCKETED


@inner
def may_fall(sought: Objective, ball: int) -> bool:
    """Whether a ball may fall into any pocket to reach the target."""
    most = 0.0
    for pocket in range(POCKETS):
        most = max(most, sought.wanted[ball][pocket])
    return most > 0.0


@inner
def pot_penalty(sought: Objective, runs: Runs, part: RunPart) -> float:
    """Penalty if no wanted ball fell: distance to a pocket or, if none was met, to the ball."""
    places, holes, wanted = sought.places, sought.holes, sought.wanted
    met = False
    for i in range(len(places)):
        if runs.balls[part.first + i].first_contact != NOTHING and may_fall(sought, i):
            met = True
    least = NO_DISTANCE
    for k in range(part.begin, part.end):
        segment = runs.segments[k]
        lasting = runs.ends[k] - segment.time
        if lasting <= 0.0:
            continue
        own = segment.ball
        for i in range(len(places)):
            if met and own == i:
                for pocket in range(POCKETS):
                    if wanted[i][pocket] > 0.0:
                        hole = holes[pocket]
                        gap = nearest(segment, lasting, hole[0], hole[1], least)
                        least = max(gap, NO_SUCCESS)
            elif not met and own != i and may_fall(sought, i):
                x, y, apart = places[i][0], places[i][1], 2.0 * sought.goals[0].ball_radius
                least = nearest(segment, lasting, x, y, least + apart) - apart
    return distance_penalty(least) if met else PENALTY_STEP + distance_penalty(least)


@inner
def hit_penalty(sought: Objective, runs: Runs, part: RunPart) -> float:
    """Penalty for the first contact with another ball, the wrong place, or the wrong direction."""
    goal, segments = sought.goals[0], runs.segments
    x, y = sought.places[goal.ball][0], sought.places[goal.ball][1]
    extra = 0.0 if goal.kind == HIT else PENALTY_STEP
    if runs.balls[part.first].first_contact != goal.ball:
        least = NO_DISTANCE
        for k in range(part.begin, part.end):
            if segments[k].ball == 0:
                if has_hit(segments[k]):
                    break
                least = nearest(segments[k], runs.ends[k] - segments[k].time, x, y, least)
        gap = least - 2.0 * goal.ball_radius
        return PENALTY_STEP + extra + min(max(gap, NO_SUCCESS), MAX_DISTANCE_PENALTY)
    if goal.kind == HIT:
        return 0.0
    if goal.kind == HIT_DIRECTION:
        return distance_penalty(direction_error(goal, segments, part))
    return distance_penalty(place_error(goal, x, y, segments, part))


@inner
def direction_error(goal: Goal, segments: list[SegmentRecord], part: RunPart) -> float:
    """
    Angle between the directions wanted and taken by a ball that is hit, less the tolerance.

    It is relative to pi. If the impact takes time, the direction is that after the release.
    """
    error, met = MAX_DISTANCE_PENALTY, False
    for k in range(part.begin, part.end):
        segment = segments[k]
        if segment.ball == goal.ball:
            if met and segment.cause != RELEASE:
                break
            if met or has_hit(segment):
                met = True
                heading = math.atan2(segment.velocity[1], segment.velocity[0])
                turn = abs(heading - math.atan2(goal.y, goal.x))
                error = (min(turn, 2.0 * math.pi - turn) - goal.radius) / math.pi
    return error


@inner
def place_error(
    goal: Goal, x: float, y: float, segments: list[SegmentRecord], part: RunPart
) -> float:
    """Distance [m] of the place where the cue ball hits the ball at (x, y), less the tolerance."""
    for k in range(part.begin, part.end):
        segment = segments[k]
        in_strike = segment.ball == goal.ball and segment.time == 0.0
        if has_hit(segment) and (segment.ball == 0 or in_strike):
            cue_ball = segments[part.begin] if in_strike else segment
            there = cue_ball.position
            px, py = there[0] - x, there[1] - y
            u, v = goal.x - x, goal.y - y
            one, two = math.sqrt(px * px + py * py), math.sqrt(u * u + v * v)
            px, py = px / one - u / two, py / one - v / two
            return goal.ball_radius * math.sqrt(px * px + py * py) - goal.radius
    return MAX_DISTANCE_PENALTY


@inner
def path_penalty(goal: Goal, runs: Runs, part: RunPart) -> float:
    """Penalty of a cue ball that has to pass a point or a gate."""
    x, y = goal.x, goal.y
    if goal.kind == GATE:
        x, y = 0.5 * (goal.x + goal.u), 0.5 * (goal.y + goal.v)
    least = NO_DISTANCE
    for k in range(part.begin, part.end):
        segment = runs.segments[k]
        if segment.ball == 0:
            lasting = runs.ends[k] - segment.time
            least = nearest(segment, lasting, x, y, least)
            if goal.kind == GATE and lasting > 0.0 and crosses(segment, lasting, goal):
                return 0.0
    if goal.kind == GATE:
        return min(max(least, NO_SUCCESS), MAX_DISTANCE_PENALTY)
    return distance_penalty(least - goal.radius)


@inner
def has_potted(wanted: Floats, balls: list[BallOutcome], first: int) -> bool:
    """Whether a ball fell into a pocket into which it may fall."""
    for i in range(len(wanted)):
        pocket = balls[first + i].pocket
        if pocket != NOTHING and wanted[i][pocket] > 0.0:
            return True
    return False


@inner
def write_ends(runs: Runs, part: RunPart, stop: float) -> None:
    """Write when each segment of a table ends: at the next one of its ball, or at the stop [s]."""
    following = runs.following
    for i in range(len(following)):
        following[i] = stop
    for k in range(part.end - 1, part.begin - 1, -1):
        segment = runs.segments[k]
        runs.ends[k] = max(following[segment.ball], segment.time)
        following[segment.ball] = segment.time


def _example(storage: Storage) -> tuple[Any, ...]:
    zeros = storage.zeros
    sought = Objective(
        storage.records(Goal, 1),
        storage.records(BallRule, 1),
        zeros(1, POCKETS),
        zeros(1, 2),
        zeros(POCKETS, 2),
    )
    runs = Runs(
        storage.records(BallOutcome, 1),
        storage.records(TableOutcome, 1),
        storage.records(SegmentRecord, 1),
        zeros(1),
        zeros(1),
    )
    return sought, runs, zeros(1)


@entry(_example)
def score_tables(sought: Objective, runs: Runs, penalties: Floats) -> None:
    """Write the penalty of each table: 0 if the target is reached, see `Outcomes`."""
    goal, count, begin = sought.goals[0], len(sought.rules), 0
    for number in range(len(runs.tables)):
        table = runs.tables[number]
        part = RunPart(number * count, begin, table.segments)
        place = runs.balls[part.first].position
        x, y = place[0] - goal.x, place[1] - goal.y
        away = math.sqrt(x * x + y * y) - goal.radius
        pots = goal.kind == POT or goal.kind == POT_AND_LEAVE
        if goal.kind == TO_REST:
            penalty = distance_penalty(away)
        elif goal.kind == FOULS:
            penalty = 0.0
        elif pots and has_potted(sought.wanted, runs.balls, part.first):
            penalty = distance_penalty(away) if goal.kind == POT_AND_LEAVE else 0.0
        else:
            write_ends(runs, part, table.duration)
            if pots:
                penalty = pot_penalty(sought, runs, part)
                if goal.kind == POT_AND_LEAVE:
                    penalty += PENALTY_STEP
            elif goal.kind == PASS or goal.kind == GATE:
                penalty = path_penalty(goal, runs, part)
            else:
                penalty = hit_penalty(sought, runs, part)
        if is_foul(sought, table, runs.balls, part.first):
            penalty += PENALTY_STEP
        penalties[number] = penalty
        begin = part.end
