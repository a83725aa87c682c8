"""
A table that is simulated to its end: event by event, in the order of their times.

If times are equal the order is: ends of segments, then what balls meet of the table, then what
balls meet, each in the order of the balls; and last the cue. Three or more bodies in touch are one
event (cluster.py). That order, and nothing else, decides; so runs are the same to the bit.
"""

import math
from typing import Any, NamedTuple

from billiard_shot.compiled import entry, inner
from billiard_shot.numerics import rounding
from billiard_shot.records import Floats, record, Storage, Vector3
from billiard_shot.status import BUDGET_EXCEEDED, INVALID_REQUEST, NEVER_RESTS, OFF_TABLE, OK
from billiard_shot.table.cluster import conclude, room_for, solve
from billiard_shot.table.cue import CueRecord, THE_CUE
from billiard_shot.table.event_handlers import (
    handle_boundary,
    handle_collision,
    handle_segment_end,
    next_event,
    NO_CLUSTER,
    start_next_segment,
)
from billiard_shot.table.gather import gather, ImpactRoom, Meeting
from billiard_shot.table.geometry import lay_out, PackedTable, TableModel
from billiard_shot.table.initial_states import ball_starts, BallStart, MIN_HEIGHT
from billiard_shot.table.motion import (
    ABSENT,
    advance_ball,
    BallRecord,
    CLUSTER,
    CUE,
    FLIGHT,
    LEFT_TABLE,
    NOTHING,
    POCKETED,
    RELEASE,
    REST,
    START,
    start_ball,
    stop_ball,
)
from billiard_shot.table.params import BallClothParams, GATE_AUTO
from billiard_shot.table.scene_params import ENDLESS
from billiard_shot.table.simulation_state import (
    log_segment,
    note_meeting,
    position_at,
    predict_collisions,
    room_for_simulation,
    Simulation,
    SimulationRoom,
)
from billiard_shot.table.strike import strike


class Beginnings(NamedTuple):
    """How tables of n balls begin."""

    balls: list[BallStart]  # n of each table, one table after the other
    cues: list[CueRecord]  # which struck ball 0 of each table, or strike it; or none


class Window(NamedTuple):
    """Until when tables are simulated, and when the places of their balls are noted."""

    until: float  # s; inf: until all balls rest; 0: only strikes are simulated
    times: Floats  # (n,) s, ascending
    places: Floats  # (tables, balls, n, 3) m, written; zero of tables that cannot be simulated


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
    status: int  # Status
    segments: int  # of this table and all before it
    events: int
    searches: int  # contacts looked for
    cue_hits: int  # how often the cue met ball 0 again, after the strike
    jaws_met: int  # rounded jaws that ball 0 met before another ball


@inner
def resume(table: TableModel, s: Simulation, cause: int, now: float) -> None:
    """Let the balls go on that were put somewhere, or that took part in an impact."""
    for i in range(len(s.balls)):
        if s.balls[i].modified:
            met = cause == CUE or (cause == START and s.balls[i].first_contact != NOTHING)
            start_next_segment(table, s, s.balls[i], CLUSTER if met and i > 0 else cause)
    for i in range(len(s.balls)):
        if s.balls[i].modified:
            predict_collisions(table, s, i, now)
        s.balls[i].modified = False


@inner
def is_decided(s: Simulation) -> bool:
    """Whether the cue hit again, a ball broke its rule, or all wanted balls have missed."""
    if s.progress.cue_hits > 0:
        return True
    met = s.balls[0].first_contact
    if met != NOTHING and s.rules[met].barred:
        return True
    missed, pending = False, False
    for i in range(len(s.balls)):
        ball, rule = s.balls[i], s.rules[i]
        if ball.motion == LEFT_TABLE or (ball.motion == POCKETED and rule.must_stay):
            return True
        if rule.sought > 0 and ball.first_contact != NOTHING:
            over = ball.motion == REST or ball.cushions > rule.sought
            missed, pending = missed or over, pending or not over
    return missed and not pending


@inner
def ending(params: BallClothParams, ball: BallRecord) -> int:
    """Status of a ball in its last segment: OK, OFF_TABLE, NEVER_RESTS or BUDGET_EXCEEDED."""
    if ball.motion == LEFT_TABLE:
        return OFF_TABLE
    if ball.motion == FLIGHT and params.cloth_restitution < 1.0:
        return BUDGET_EXCEEDED
    return OK if ball.motion == REST or ball.motion > FLIGHT else NEVER_RESTS


@inner
def note_places(s: Simulation, window: Window, number: int, noted: int, time: float) -> int:
    """
    Note where the balls of a table are at the times of a window before the given one.

    The first `noted` are noted already; return how many are then.
    """
    while noted < len(window.times) and window.times[noted] < time:
        for i in range(len(s.balls)):
            place = window.places[number][i][noted]
            place[0], place[1], place[2] = position_at(s.balls[i], window.times[noted])
        noted += 1
    return noted


@inner
def stop_all(s: Simulation, time: float) -> int:
    """Bring all balls to a time, as their last segments; return the status of the table."""
    status = OK
    for i in range(len(s.balls)):
        ball = s.balls[i]
        if ball.motion == LEFT_TABLE:
            status = OFF_TABLE
        elif ball.motion != REST and ball.motion <= FLIGHT:
            advance_ball(ball, time)
            ball.cause = RELEASE  # which is no event if the motion goes on
            log_segment(s, ball)
    return status


@inner
def run_events(
    table: TableModel,
    s: Simulation,
    cues: list[CueRecord],
    number: int,
    max_events: int,
    window: Window,
    room: ImpactRoom,
) -> tuple[float, int]:
    """
    Simulate until nothing moves, or only endlessly, or all is decided, or the window ends.

    Return when that is [s], and the status of the table.
    """
    p, now, noted = s.progress, 0.0, 0
    resume(table, s, START, now)
    while True:
        time, i, j = next_event(s)
        noted = note_places(s, window, number, noted, min(time, window.until))
        if time > window.until:
            note_places(s, window, number, noted, math.inf)
            return window.until, stop_all(s, window.until)
        if time == math.inf:
            break
        if p.events >= max_events:
            return now, BUDGET_EXCEEDED
        now, reach = time, NO_CLUSTER
        if j == NOTHING:
            handle_segment_end(table, s, s.balls[i])
        elif j == THE_CUE and len(s.rules) > 0:
            p.cue_hits += 1  # a foul decides the run: nobody needs to know where the ball goes
        elif j == THE_CUE:
            reach = table.cue.neighbour_reach
        elif j == i:
            handle_boundary(table, s, s.balls[i])
        else:
            reach = handle_collision(table, s, i, j, now)
        if reach != NO_CLUSTER:
            impact = gather(table, s, cues, number, Meeting(now, i, j, reach), room)
            solve(table, impact, room)
            conclude(table, s, cues, number, impact, room)
        if p.unsolved != OK:
            return now, p.unsolved
        if reach != NO_CLUSTER:
            resume(table, s, CUE if j == THE_CUE else CLUSTER, now)
        elif len(s.rules) > 0 and is_decided(s):
            return now, OK
        else:
            predict_collisions(table, s, i, now)
            if j >= 0 and j != i:
                predict_collisions(table, s, j, now)
    status = OK
    for i in range(len(s.balls)):
        status = max(status, ending(table.params, s.balls[i]))
    return now, p.flaw if status == OK else status


@inner
def begin_table(table: TableModel, s: Simulation, beginnings: Beginnings, number: int) -> bool:
    """Put the balls and the cue of a table where they begin; return whether they can be there."""
    p, cue, n, radius = s.progress, s.cue, table.numbers, table.params.radius
    out_x, out_y = n.nose_half_length + n.cushion_depth, n.nose_half_width + n.cushion_depth
    p.events, p.participants, p.searches = 0, 0, 0  # but segments go on from table to table
    p.cue_hits, p.unsolved, p.flaw = 0, OK, OK
    cue.meeting_time, cue.time, cue.end = math.inf, 0.0, 0.0
    for i in range(len(s.balls)):
        ball, start = s.balls[i], beginnings.balls[number * len(s.balls) + i]
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
    if len(beginnings.cues) > 0:
        stroke = beginnings.cues[number]
        for k in range(3):
            cue.position[k], cue.velocity[k] = stroke.tip[k], stroke.speed * stroke.axis[k]
        cue.end = stroke.end
        cue.motion = FLIGHT  # its height counts
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


def _example(storage: Storage) -> tuple[Any, ...]:
    """One ball on the cloth."""
    params = BallClothParams(*(1.0,) * 10, 0, 1.0, GATE_AUTO, GATE_AUTO)
    starts = ball_starts(1, 1)
    starts['position'] = 0.0, 0.0, 1.0
    return (
        lay_out(storage, params, ENDLESS),
        room_for_simulation(storage, 1),
        Beginnings(
            storage.from_rows(BallStart, starts[0]),
            storage.records(CueRecord, 1),
        ),
        1,
        room_for(storage, 1, True),
        storage.records(BallOutcome, 1),
        storage.records(TableOutcome, 1),
        Window(math.inf, storage.zeros(1), storage.zeros(1, 1, 1, 3)),
    )


@entry(_example)
def simulate_tables(
    layout: PackedTable,
    simulation: SimulationRoom,
    beginnings: Beginnings,
    max_events: int,
    room: ImpactRoom,
    ball_outcomes: list[BallOutcome],
    table_outcomes: list[TableOutcome],
    window: Window,
) -> None:
    """
    Simulate tables, one after the other, each to its end.

    Parameters
    ----------
    layout : PackedTable
    simulation : SimulationRoom
        For the present table; at first `room_for_simulation`. Segments of all tables and events of
        the last one are recorded as far as there is room.
    beginnings : Beginnings
        Cues that strike are changed.
    max_events : int
        Of a table.
    room : ImpactRoom
        For impacts of several bodies; afterwards it has the last one.
    ball_outcomes, table_outcomes : tables n BallOutcome, tables TableOutcome, written
    window : Window
        Its places are written.

    """
    table = TableModel(
        layout.params,
        layout.numbers[0],
        layout.jaws,
        layout.pockets,
        layout.rebounds,
        layout.cue,
    )
    s = Simulation(
        simulation.balls,
        simulation.collisions,
        simulation.progress[0],
        simulation.rebound[0],
        simulation.segments,
        simulation.events,
        rules=simulation.rules,
        cue=simulation.cue[0],
    )
    p, cues, count = s.progress, beginnings.cues, len(s.balls)
    p.segments = p.events = p.participants = 0
    for number in range(len(table_outcomes)):
        outcome = table_outcomes[number]
        valid = begin_table(table, s, beginnings, number)
        outcome.duration, outcome.status = 0.0, OK if valid else INVALID_REQUEST
        if valid and len(cues) > 0 and cues[number].strikes:
            strike(table, s, cues, number, room)
        if valid and window.until > 0.0:
            outcome.duration, outcome.status = run_events(
                table, s, cues, number, max_events, window, room=room
            )
        outcome.segments, outcome.events = p.segments, p.events
        outcome.searches, outcome.cue_hits = p.searches, p.cue_hits
        outcome.jaws_met = s.balls[0].jaws if valid else 0
        for i in range(count):
            write_outcome(s.balls[i], ball_outcomes[number * count + i], valid)
