"""
How near recorded runs came to a target; the targets make penalties of it, see targets.py.

Each missing step towards a target costs `PENALTY_STEP`. The remaining distance [m] is added; it is
less than a step, so that a stroke that misses fewer steps has the smaller penalty. Paths are
approximated by straight lines, `PENALTY_PIECES` to a segment.
"""

from enum import IntEnum
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.records import Array, Floats, Storage
from billiard_shot.table.model.motion import (
    BALL,
    CLUSTER,
    POCKETED,
    RELEASE,
    SegmentRecord,
    TableOutcome,
)
from billiard_shot.table.run.task import BatchRecording

PENALTY_STEP = 1.0
MAX_DISTANCE_PENALTY = 0.99
NO_SUCCESS = 1e-6  # m: smallest penalty of a target that was not reached
PENALTY_PIECES = 6
NO_DISTANCE = 1e3  # m: stands for "no distance"


class Measure(IntEnum):
    """What is measured on the paths of a table."""

    APPROACH = 0  # smallest distance between balls and the points that they seek [m]
    APPROACH_BEFORE_HIT = 1  # the same, until the cue ball meets a ball
    CROSSING = 2  # 0 if the cue ball crosses the line between two points
    DIRECTION = 3  # angle between a direction and that in which a ball leaves that is hit [rad]
    PLACE = 4  # distance of a point from the place where a ball is hit, on a unit circle


_, BEFORE_HIT, CROSSING, DIRECTION, PLACE = map(int, Measure)


class Sought(NamedTuple):
    """What the balls of a table are to come near."""

    ball: int  # that is to be hit
    apart: float  # m: from distances between centres this is subtracted
    points: Floats  # (points, 2) m: also ends of a line, a direction, or a ball and a point
    seeking: Floats  # (balls, points) above 0 if the ball seeks the point


class Runs(NamedTuple):
    """Recorded runs of tables with n balls, and scratch."""

    tables: list[TableOutcome]
    segments: list[SegmentRecord]
    ends: Floats  # (segments,) scratch, see `write_ends`
    following: Floats  # (n,) scratch


class RunPart(NamedTuple):
    """The part of `Runs` that belongs to one table: its segments."""

    begin: int
    end: int


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
def approach(measure: int, sought: Sought, runs: Runs, part: RunPart, least: float) -> float:
    """Smallest distance [m] between balls and the points that they seek, or `least`."""
    for k in range(part.begin, part.end):
        segment = runs.segments[k]
        if measure == BEFORE_HIT and segment.ball == 0 and has_hit(segment):
            break
        lasting = runs.ends[k] - segment.time
        for i in range(len(sought.points)):
            if sought.seeking[segment.ball][i] > 0.0:
                x, y, apart = sought.points[i][0], sought.points[i][1], sought.apart
                least = nearest(segment, lasting, x, y, least + apart) - apart
    return least


@inner
def crosses(segment: SegmentRecord, lasting: float, ends: Floats) -> bool:
    """Whether a segment crosses the line between two points."""
    p, w, a = segment.position, segment.velocity, segment.acceleration
    x, y, u, v = ends[0][0], ends[0][1], ends[1][0], ends[1][1]
    lx, ly = u - x, v - y
    px, py = p[0] - x, p[1] - y
    for i in range(1, PENALTY_PIECES + 1):
        t = lasting * i / PENALTY_PIECES
        qx = p[0] - x + t * (w[0] + 0.5 * t * a[0])
        qy = p[1] - y + t * (w[1] + 0.5 * t * a[1])
        one, two = lx * py - ly * px, lx * qy - ly * qx
        if one * two <= 0.0 and one != two:
            part = one / (one - two)
            along = (px + part * (qx - px)) * lx + (py + part * (qy - py)) * ly
            if 0.0 <= along <= lx * lx + ly * ly:
                return True
        px, py = qx, qy
    return False


@inner
def misses_line(sought: Sought, runs: Runs, part: RunPart) -> float:
    """Return 0 if the cue ball crosses the line between two points, else 1."""
    for k in range(part.begin, part.end):
        segment = runs.segments[k]
        lasting = runs.ends[k] - segment.time
        if segment.ball == 0 and lasting > 0.0 and crosses(segment, lasting, sought.points):
            return 0.0
    return 1.0


@inner
def has_hit(segment: SegmentRecord) -> bool:
    """Whether a segment starts with a collision of balls."""
    return (segment.cause == BALL or segment.cause == CLUSTER) and segment.motion < POCKETED


@inner
def direction_error(sought: Sought, segments: list[SegmentRecord], part: RunPart) -> float:
    """
    Angle [rad] between the directions wanted and taken by a ball that is hit.

    If the impact takes time, the direction is that after the release.
    """
    error, met = NO_DISTANCE, False
    for k in range(part.begin, part.end):
        segment = segments[k]
        if segment.ball == sought.ball:
            if met and segment.cause != RELEASE:
                break
            if met or has_hit(segment):
                met = True
                heading = math.atan2(segment.velocity[1], segment.velocity[0])
                turn = abs(heading - math.atan2(sought.points[0][1], sought.points[0][0]))
                error = min(turn, 2.0 * math.pi - turn)
    return error


@inner
def place_error(sought: Sought, segments: list[SegmentRecord], part: RunPart) -> float:
    """Distance, in ball radii, of the place where the cue ball hits a ball from the wanted one."""
    x, y = sought.points[0][0], sought.points[0][1]
    to_x, to_y = sought.points[1][0], sought.points[1][1]
    for k in range(part.begin, part.end):
        segment = segments[k]
        in_strike = segment.ball == sought.ball and segment.time == 0.0
        if has_hit(segment) and (segment.ball == 0 or in_strike):
            cue_ball = segments[part.begin] if in_strike else segment
            there = cue_ball.position
            px, py = there[0] - x, there[1] - y
            u, v = to_x - x, to_y - y
            one, two = math.sqrt(px * px + py * py), math.sqrt(u * u + v * v)
            px, py = px / one - u / two, py / one - v / two
            return math.sqrt(px * px + py * py)
    return NO_DISTANCE


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
    sought = Sought(0, 1.0, storage.zeros(2, 2), storage.zeros(1, 2))
    tables, segments = storage.records(TableOutcome, 1), storage.records(SegmentRecord, 1)
    return 0, sought, Runs(tables, segments, storage.zeros(1), storage.zeros(1)), storage.zeros(1)


@entry(_example)
def measure_tables(measure: int, sought: Sought, runs: Runs, found: Floats) -> None:
    """Measure each table for which `found` is above 0, a largest distance, and replace that."""
    begin = 0
    for number in range(len(runs.tables)):
        table = runs.tables[number]
        part = RunPart(begin, table.segments)
        begin = part.end
        if found[number] <= 0.0:
            continue
        if measure == DIRECTION:
            found[number] = direction_error(sought, runs.segments, part)
        elif measure == PLACE:
            found[number] = place_error(sought, runs.segments, part)
        else:
            write_ends(runs, part, table.duration)
            if measure == CROSSING:
                found[number] = misses_line(sought, runs, part)
            else:
                found[number] = approach(measure, sought, runs, part, found[number])


def measured(
    measure: Measure,
    recording: BatchRecording,
    points: ArrayLike,
    *,
    seeking: Array | None = None,
    ball: int = 0,
    apart: float = 0.0,
    which: NDArray[np.bool_] | None = None,
) -> Array:
    """
    Measure recorded tables.

    Parameters
    ----------
    measure : Measure
    recording : BatchRecording
        Of n tables.
    points, seeking, ball, apart
        See `Sought`; by default the cue ball seeks all points.
    which : (n,) bool array, optional
        The tables to be measured; the result is 0 for the others.

    Returns
    -------
    (n,) float array
        See `Measure`; `NO_DISTANCE` if there is none.

    """
    run = measure_tables.current()
    array, zeros, from_rows = run.storage.array, run.storage.zeros, run.storage.from_rows
    count, balls = recording.balls.shape
    places = np.array(points, dtype=float)
    if seeking is None:
        seeking = np.zeros((balls, len(places)))
        seeking[0] = 1.0
    found = array(np.where(np.ones(count, np.bool_) if which is None else which, NO_DISTANCE, 0.0))
    runs = Runs(
        from_rows(TableOutcome, recording.tables),
        from_rows(SegmentRecord, recording.segments),
        zeros(len(recording.segments)),
        zeros(balls),
    )
    run(int(measure), Sought(ball, float(apart), array(places), array(seeking)), runs, found)
    return np.asarray(found)


def distance_penalty(gap: Array) -> Array:
    """Penalty of distances [m] that are missing; 0 if none is."""
    return np.clip(gap, 0.0, MAX_DISTANCE_PENALTY)


def miss_penalty(gap: Array) -> Array:
    """Penalty of distances [m] that are missing although they may be 0."""
    return np.clip(gap, NO_SUCCESS, MAX_DISTANCE_PENALTY)
