"""
A table that is simulated to its end: event by event, in the order of their times.

If times are equal the order is: ends of segments, then what balls meet of the table, then what
balls meet, each in the order of the balls; and last the cue. Three or more bodies in touch are one
event (cluster.py). That order, and nothing else, decides; so runs are the same to the bit.
"""

import math
from typing import NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.records import Floats
from billiard_shot.status import BUDGET_EXCEEDED, NEVER_RESTS, OFF_TABLE, OK
from billiard_shot.table.contacts.balls import predict_collisions
from billiard_shot.table.contacts.cluster import conclude, solve
from billiard_shot.table.contacts.gather import gather, ImpactWorkspace, Meeting
from billiard_shot.table.model.cue import chatters, CueRecord, THE_CUE
from billiard_shot.table.model.geometry import BallClothParams, TableModel
from billiard_shot.table.model.motion import (
    advance_ball,
    BallRecord,
    BallRule,
    CLUSTER,
    CUE,
    FLIGHT,
    LEFT_TABLE,
    log_segment,
    NOTHING,
    POCKETED,
    position_at,
    RELEASE,
    REST,
    Simulation,
    START,
)
from billiard_shot.table.run.event_handlers import (
    handle_boundary,
    handle_collision,
    handle_segment_end,
    next_event,
    NO_CLUSTER,
    start_next_segment,
)

PLACED = -math.inf  # s, in place of the end of a run: cues are placed, and nothing is simulated


class RunLimits(NamedTuple):
    """What ends the runs of tables, and the times at which they return the places of the balls."""

    until: float  # s; inf: until all balls rest; 0: only strikes are simulated; or PLACED
    max_events: int  # of a table
    rules: list[BallRule]  # of each ball, or none: the run goes on until all rest
    times: Floats  # (n,) s, ascending
    places: Floats  # (tables, balls, n, 3) m, written; zero of tables that cannot be simulated


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
def is_decided(s: Simulation, cue: CueRecord) -> bool:
    """Whether the stroke failed, a ball broke its rule, or all wanted balls have missed."""
    if cue.miscue or s.progress.double_hit:
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
def note_places(s: Simulation, window: RunLimits, number: int, noted: int, time: float) -> int:
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
def note_hit(params: BallClothParams, s: Simulation, cue: CueRecord, time: float) -> None:
    """Note that the cue meets the ball again, after the strike."""
    ball, (_, _, z) = s.balls[0], position_at(s.balls[0], time)
    alone = ball.first_contact == NOTHING and ball.cushions == 0
    if alone and chatters(cue.tip_time + time, z - params.radius):
        cue.chatter = True
    else:
        s.progress.double_hit = True
        cue.double_hit = min(cue.double_hit, time)


@inner
def run_events(
    table: TableModel,
    s: Simulation,
    cues: list[CueRecord],
    number: int,
    window: RunLimits,
    room: ImpactWorkspace,
) -> tuple[float, int]:
    """
    Simulate until nothing moves, or only endlessly, or all is decided, or the window ends.

    With rules, a stroke that failed already in the strike ends there.

    Return when that is [s], and the status of the table.
    """
    p, now, noted = s.progress, 0.0, 0
    if len(s.rules) > 0 and is_decided(s, cues[number]):
        return now, OK
    resume(table, s, START, now)
    while True:
        time, i, j = next_event(s)
        noted = note_places(s, window, number, noted, min(time, window.until))
        if time > window.until:
            note_places(s, window, number, noted, math.inf)
            return window.until, stop_all(s, window.until)
        if time == math.inf:
            break
        if p.events >= window.max_events:
            return now, BUDGET_EXCEEDED
        now, reach = time, NO_CLUSTER
        if j == NOTHING:
            handle_segment_end(table, s, s.balls[i])
        elif j == THE_CUE:
            note_hit(table.params, s, cues[number], now)
            if not p.double_hit or len(s.rules) == 0:
                reach = table.cue.neighbour_reach
            # else a foul decides the run: nobody needs to know where the ball goes
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
        if len(s.rules) > 0 and is_decided(s, cues[number]):
            return now, OK
        if reach == NO_CLUSTER:
            predict_collisions(table, s, i, now)
            if j >= 0 and j != i:
                predict_collisions(table, s, j, now)
    status = OK
    for i in range(len(s.balls)):
        status = max(status, ending(table.params, s.balls[i]))
    return now, p.flaw if status == OK else status
