"""
The entry for strokes at tables, and for tables without: each from its beginning to its end.

This is the one place that decides how a stroke ended: alone, in a batch, or on a table of its own.
"""

import math
from typing import Any, NamedTuple

from billiard_shot.compiled import entry, inner, innermost
from billiard_shot.numerics import rounding
from billiard_shot.records import record, Storage, Vector3
from billiard_shot.status import INFINITE_SEQUENCE, INVALID_REQUEST, OK, TOLERANCE_NOT_REACHED
from billiard_shot.table.contacts.cluster import room_for
from billiard_shot.table.contacts.gather import ImpactWorkspace
from billiard_shot.table.model.cue import CueRecord
from billiard_shot.table.model.geometry import BallClothParams, PackedTable, TableModel
from billiard_shot.table.model.motion import (
    ABSENT,
    BallRecord,
    BallRule,
    BallStart,
    EventRecord,
    note_meeting,
    NOTHING,
    room_for_simulation,
    SegmentRecord,
    Simulation,
    SimulationRoom,
    start_ball,
    stop_ball,
)
from billiard_shot.table.run.event_loop import PLACED, run_events, RunLimits
from billiard_shot.table.run.layout import ENDLESS, lay_out
from billiard_shot.table.run.states import ball_starts, MIN_HEIGHT
from billiard_shot.table.strike.placement import (
    CUSHION_SHARE,
    FINER,
    HOPS,
    HOPS_BEFORE_CUSHIONS,
    LEFT,
    NO_STROKES,
    place_cue,
    ROLLS,
    Strokes,
)
from billiard_shot.table.strike.strike import strike


@record
class BallOutcome:
    """How a ball ends."""

    position: Vector3  # m
    velocity: Vector3  # m/s
    spin: Vector3  # rad/s
    motion: int  # Motion
    pocket: int  # in which it lies, or NOTHING
    first_contact: int  # index of the first ball that it met, or NOTHING
    time: float  # s, since when it rests or, if it never does, its last motion lasts
    cushions: int  # straight cushions that it met; this and the next three as in `BallRecord`
    last_edge: float
    met_time: float
    met_after: int
    left_out: float  # m, see `BallRecord`


@record
class TableOutcome:
    """How the simulation of a table ends."""

    duration: float  # s
    status: int  # Status: of the stroke, of its run or of its accuracy; else of the run
    run_status: int  # Status: of the run alone
    error: float  # m, estimate for the trajectory after a stroke; 0: it is not estimated
    segments: int  # of this table and all before it
    events: int
    searches: int  # contacts looked for
    double_hit: bool  # the cue hit ball 0 again, in the strike or later; chatter does not count
    jaws_met: int  # rounded jaws that ball 0 met before another ball


class Tables(NamedTuple):
    """Tables of n balls: how they begin, and how they end. Outcomes are zero at first."""

    starts: list[BallStart]  # n of each table, or n for all tables alike
    cues: list[CueRecord]  # of each table, written; none without strokes
    balls: list[BallOutcome]  # n of each table, written
    ends: list[TableOutcome]  # of each table, written
    segments: list[SegmentRecord]  # of all tables, written as far as there is room
    events: list[EventRecord]  # of the last table, written as far as there is room


@inner
def begin_table(table: TableModel, s: Simulation, starts: list[BallStart], first: int) -> bool:
    """Put down the balls of a table, from `first` on, and return whether they can be there."""
    p, cue, n, radius = s.progress, s.cue, table.numbers, table.params.radius
    out_x, out_y = n.nose_half_length + n.cushion_depth, n.nose_half_width + n.cushion_depth
    p.events, p.participants, p.searches = 0, 0, 0  # but segments go on from table to table
    p.double_hit, p.cue_touches, p.unsolved, p.flaw = False, 0, OK, OK
    cue.meeting_time, cue.time, cue.end = math.inf, 0.0, 0.0
    for i in range(len(s.balls)):
        ball, start = s.balls[i], starts[first + i]
        for j in range(i + 1, len(s.balls)):
            s.collisions[i][j] = math.inf
        for vector in (start.position, start.velocity, start.spin):
            for k in range(3):
                if not math.isfinite(vector[k]):
                    return False
        start_ball(ball, start.position, start.velocity, start.spin)
        ball.ball, ball.modified, ball.first_contact = i, True, start.first_contact
        if start.absent:
            stop_ball(ball, ABSENT)
            continue
        if abs(ball.position[0]) > out_x or abs(ball.position[1]) > out_y:
            return False
        if ball.position[2] < radius * MIN_HEIGHT:
            return False
        for j in range(i):
            if s.balls[j].motion == ABSENT:
                continue
            square = 0.0
            for k in range(3):
                apart = ball.position[k] - s.balls[j].position[k]
                square += apart * apart
            if math.sqrt(square) < 2.0 * radius - rounding.PLACE:
                return False
    for i in range(1, len(s.balls)):
        if s.balls[0].first_contact == i or s.balls[i].first_contact == 0:
            note_meeting(s, 0, i, 0.0)
    return True


@inner
def write_outcome(ball: BallRecord, outcome: BallOutcome, valid: bool) -> None:
    """Write how a ball ends; zeros, if it cannot begin."""
    if not valid:
        outcome.pocket, outcome.first_contact = NOTHING, NOTHING
        outcome.last_edge, outcome.met_time = -math.inf, math.inf
        return
    for k in range(3):
        outcome.position[k], outcome.velocity[k] = ball.position[k], ball.velocity[k]
        outcome.spin[k] = ball.spin[k]
    outcome.motion, outcome.pocket = ball.motion, ball.pocket
    outcome.first_contact, outcome.time = ball.first_contact, ball.time
    outcome.cushions, outcome.last_edge = ball.cushions, ball.last_edge
    outcome.met_time, outcome.met_after = ball.met_time, ball.met_after
    outcome.left_out = ball.left_out


# This function and `play_table` are inlined: the arrays in their arguments are a thousand numbers,
# and to pass these on takes longer than all else that they do.
@innermost
def run_table(
    layout: PackedTable,
    s: Simulation,
    tables: Tables,
    strokes: Strokes,
    number: int,
    tolerance: float,
    window: RunLimits,
    room: ImpactWorkspace,
) -> None:
    """Let balls and cue of a table begin, and simulate it to its end, for a tolerance [m]."""
    count, cues, outcome, n = len(s.balls), tables.cues, tables.ends[number], layout.numbers[0]
    hops = 1.0
    if len(cues) > 0:
        hops = HOPS_BEFORE_CUSHIONS if strokes.checked and not n.endless else HOPS
    bounces = hops * tolerance
    table = TableModel(
        layout.params,
        n,
        layout.jaws,
        layout.pockets,
        layout.rebounds,
        layout.cue,
        bounces,
        tolerance,
    )
    first = number * count % len(tables.starts)
    valid = begin_table(table, s, tables.starts, first)
    outcome.duration, outcome.run_status = 0.0, OK if valid else INVALID_REQUEST
    if len(cues) > 0:
        place_cue(table, s, tables.starts, first, strokes, number, tolerance, cues[number])
        if valid and cues[number].strikes and window.until != PLACED:
            strike(table, s, cues, number, room)
            s.progress.double_hit = cues[number].double_hit == 0.0
    if valid and window.until > 0.0:
        outcome.duration, outcome.run_status = run_events(table, s, cues, number, window, room)
    p = s.progress
    outcome.segments, outcome.events = p.segments, p.events
    outcome.searches, outcome.double_hit = p.searches, p.double_hit
    outcome.jaws_met = s.balls[0].jaws if valid else 0
    for i in range(count):
        write_outcome(s.balls[i], tables.balls[number * count + i], valid)


@inner
def estimated_error(
    layout: PackedTable, cue: CueRecord, ball: BallOutcome, tolerance: float
) -> float:
    """Estimate the error of the trajectory of a ball after a stroke [m]."""
    error = cue.drift * ball.time
    if layout.numbers[0].endless:
        error += ball.left_out
        if layout.params.rolling_rise > 0.0:
            error += ROLLS * tolerance
    elif error > 0.0:
        error += CUSHION_SHARE * tolerance
    return error


@innermost
def play_table(
    layout: PackedTable,
    s: Simulation,
    tables: Tables,
    strokes: Strokes,
    number: int,
    tolerance: float,
    window: RunLimits,
    room: ImpactWorkspace,
) -> None:
    """
    Play the stroke at a table, if there is one, and decide how it ended.

    It ends as the strike; if that went well, as the run; if that went well, as its accuracy says.
    A checked stroke whose ball meets rounded jaws of pockets is played again, finer: each jaw
    magnifies an error a few hundred times. The change then tells the error.
    """
    segments, end, status = s.progress.segments, tables.ends[number], OK
    run_table(layout, s, tables, strokes, number, tolerance, window, room)
    if len(tables.cues) > 0:
        cue, ball = tables.cues[number], tables.balls[number * len(s.balls)]
        status = cue.status
        if strokes.checked:
            end.error = estimated_error(layout, cue, ball, tolerance)
            if end.jaws_met > 0:
                x, y, z = ball.position[0], ball.position[1], ball.position[2]
                s.progress.segments = segments
                finer = FINER * tolerance
                run_table(layout, s, tables, strokes, number, finer, window, room)
                if ball.first_contact == NOTHING:
                    x, y, z = ball.position[0] - x, ball.position[1] - y, ball.position[2] - z
                    end.error = max(end.error, LEFT * math.sqrt(x * x + y * y + z * z))
                if cue.status != TOLERANCE_NOT_REACHED:  # as fine as an impact can be solved
                    status = cue.status
    if status in (OK, INFINITE_SEQUENCE):
        if end.run_status != OK:
            status = end.run_status
        elif end.error > tolerance:
            status = TOLERANCE_NOT_REACHED
    end.status = status


def _example(storage: Storage) -> tuple[Any, ...]:
    """One ball on the cloth."""
    params = BallClothParams(*(1.0,) * 10, 0, 1.0)
    starts = ball_starts(1, 1)
    starts['position'] = 0.0, 0.0, 1.0
    return (
        Tables(
            storage.from_rows(BallStart, starts[0]),
            storage.records(CueRecord, 1),
            storage.records(BallOutcome, 1),
            storage.records(TableOutcome, 1),
            storage.records(SegmentRecord, 1),
            storage.records(EventRecord, 1),
        ),
        NO_STROKES.stored(storage, 1),
        1.0,
        RunLimits(
            math.inf,
            1,
            storage.records(BallRule, 1),
            storage.zeros(1),
            storage.zeros(1, 1, 1, 3),
        ),
        lay_out(storage, params, ENDLESS),
        room_for_simulation(storage, 1),
        room_for(storage, 1, True),
    )


@entry(_example, kept=3)
def play_tables(
    tables: Tables,
    strokes: Strokes,
    tolerance: float,
    window: RunLimits,
    layout: PackedTable,
    simulation: SimulationRoom,
    room: ImpactWorkspace,
) -> None:
    """
    Play a stroke at each of many tables, or simulate them without, one after the other.

    Statuses, errors and repetitions are decided here, so that all callers find the same. Callers
    make vectors of offsets by `write_strokes`, and give larger arrays if segments, events or
    phases did not fit. Python adds messages, and how far the outcomes of law `energetic` jump
    (shot/play.py); other callers find no jumps.

    Parameters
    ----------
    tables : Tables
        The numbers in its outcomes say if there was no room for segments or events.
    strokes : Strokes
        Of each table; or none.
    tolerance : float
        Of trajectories after strokes [m]. Without strokes, hops that move a ball by less than
        this are left out.
    window : RunLimits
        Its places are written.
    layout : PackedTable
    simulation : SimulationRoom
        For the present table; at first `room_for_simulation`.
    room : ImpactWorkspace
        For impacts of several bodies; afterwards it has the last one.

    """
    s = Simulation(
        simulation.balls,
        simulation.collisions,
        simulation.progress[0],
        simulation.rebound[0],
        tables.segments,
        tables.events,
        rules=window.rules,
        cue=simulation.cue[0],
    )
    p = s.progress
    p.segments = p.events = p.participants = 0
    for number in range(len(tables.ends)):
        play_table(layout, s, tables, strokes, number, tolerance, window, room)
