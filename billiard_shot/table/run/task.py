"""
Tables from their beginnings to their ends: the compiled entry, and batches on all cores.

`play_tables` is the entry for strokes at tables, and for tables without. It is the one place that
decides how a stroke ended: alone, in a batch, or on a table of its own.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
import math
import os
import threading
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner, innermost
from billiard_shot.impact.state import PhaseLog
from billiard_shot.numerics import rounding
from billiard_shot.records import as_rows, ROWS, Storage
from billiard_shot.status import INFINITE_SEQUENCE, INVALID_REQUEST, OK, TOLERANCE_NOT_REACHED
from billiard_shot.table.contacts.cluster import room_for
from billiard_shot.table.contacts.gather import ImpactWorkspace
from billiard_shot.table.model import geometry, motion
from billiard_shot.table.model.cue import CueParams, CueRecord, NO_CUE
from billiard_shot.table.run.event_loop import PLACED, run_events, RunLimits
from billiard_shot.table.run.layout import ENDLESS, lay_out
from billiard_shot.table.run.results import EventLog
from billiard_shot.table.run.states import ball_starts, MIN_HEIGHT
from billiard_shot.table.strike import placement
from billiard_shot.table.strike.strike import strike


class Tables(NamedTuple):
    """Tables of n balls: how they begin, and how they end. Outcomes are zero at first."""

    starts: list[motion.TableBall]  # n of each table, or n for all tables alike
    cues: list[CueRecord]  # of each table, written; none without strokes
    balls: list[motion.TableBall]  # n of each table, written
    ends: list[motion.TableOutcome]  # of each table, written
    segments: list[motion.SegmentRecord]  # of all tables, written as far as there is room
    events: list[motion.EventRecord]  # of the last table, written as far as there is room


@inner
def begin_table(
    table: geometry.TableModel, s: motion.Simulation, starts: list[motion.TableBall], first: int
) -> bool:
    """Put down the balls of a table, from `first` on, and return whether they can be there."""
    p, cue, n, radius = s.progress, s.cue, table.numbers, table.params.radius
    out_x, out_y = n.nose_half_length + n.cushion_depth, n.nose_half_width + n.cushion_depth
    p.events, p.participants, p.searches = 0, 0, 0
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
        motion.start_ball(ball, start.position, start.velocity, start.spin)
        ball.ball, ball.modified, ball.first_contact = i, True, start.first_contact
        if start.motion == motion.ABSENT:
            motion.stop_ball(ball, motion.ABSENT)
            continue
        if abs(ball.position[0]) > out_x or abs(ball.position[1]) > out_y:
            return False
        if ball.position[2] < radius * MIN_HEIGHT:
            return False
        for j in range(i):
            if s.balls[j].motion == motion.ABSENT:
                continue
            square = 0.0
            for k in range(3):
                apart = ball.position[k] - s.balls[j].position[k]
                square += apart * apart
            if math.sqrt(square) < 2.0 * radius - rounding.PLACE:
                return False
    for i in range(1, len(s.balls)):
        if s.balls[0].first_contact == i or s.balls[i].first_contact == 0:
            motion.note_meeting(s, 0, i, 0.0)
    return True


@inner
def write_outcome(ball: motion.BallRecord, outcome: motion.TableBall, valid: bool) -> None:
    """Write how a ball ends; zeros, if it cannot begin."""
    if not valid:
        outcome.pocket, outcome.first_contact = motion.NOTHING, motion.NOTHING
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


# This function is inlined: the arrays in its arguments are a thousand numbers, and to pass these
# on takes longer than all else that it does.
@innermost
def run_table(
    layout: geometry.PackedTable,
    s: motion.Simulation,
    tables: Tables,
    strokes: placement.Strokes,
    number: int,
    tolerance: float,
    window: RunLimits,
    room: ImpactWorkspace,
) -> None:
    """Let balls and cue of a table begin, and simulate it to its end, for a tolerance [m]."""
    count, cues, outcome, n = len(s.balls), tables.cues, s.progress, layout.numbers[0]
    outcome.segments = tables.ends[number - 1].segments if number > 0 else 0
    hops = 1.0
    if len(cues) > 0:
        hops = (
            placement.HOPS_BEFORE_CUSHIONS if strokes.checked and not n.endless else placement.HOPS
        )
    bounces = hops * tolerance
    table = geometry.TableModel(
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
        placement.place_cue(
            table, s, tables.starts, first, strokes, number, tolerance, cues[number]
        )
        if valid and cues[number].strikes and window.until != PLACED:
            strike(table, s, cues, number, room)
            outcome.double_hit = cues[number].double_hit == 0.0
    if valid and window.until > 0.0:
        outcome.duration, outcome.run_status = run_events(table, s, cues, number, window, room)
    outcome.jaws_met = s.balls[0].jaws if valid else 0
    for i in range(count):
        write_outcome(s.balls[i], tables.balls[number * count + i], valid)


@inner
def estimated_error(
    layout: geometry.PackedTable, cue: CueRecord, ball: motion.TableBall, tolerance: float
) -> float:
    """Estimate the error of the trajectory of a ball after a stroke [m]."""
    error = cue.drift * ball.time
    if layout.numbers[0].endless:
        error += ball.left_out
        if layout.params.rolling_rise > 0.0:
            error += placement.ROLLS * tolerance
    elif error > 0.0:
        error += placement.CUSHION_SHARE * tolerance
    return error


def _example(storage: Storage) -> tuple[Any, ...]:
    """One ball on the cloth."""
    params = geometry.BallClothParams(*(1.0,) * 10, 0, 1.0)
    starts = ball_starts(1, 1)
    starts['position'] = 0.0, 0.0, 1.0
    return (
        Tables(
            storage.from_rows(motion.TableBall, starts[0]),
            storage.records(CueRecord, 1),
            storage.records(motion.TableBall, 1),
            storage.records(motion.TableOutcome, 1),
            storage.records(motion.SegmentRecord, 1),
            storage.records(motion.EventRecord, 1),
        ),
        placement.NO_STROKES.stored(storage, 1),
        1.0,
        RunLimits(
            math.inf,
            1,
            storage.records(motion.BallRule, 1),
            storage.zeros(1),
            storage.zeros(1, 1, 1, 3),
        ),
        lay_out(storage, params, ENDLESS),
        motion.room_for_simulation(storage, 1),
        room_for(storage, 1, True),
    )


@entry(_example, kept=3)
def play_tables(
    tables: Tables,
    strokes: placement.Strokes,
    tolerance: float,
    window: RunLimits,
    layout: geometry.PackedTable,
    simulation: motion.SimulationRoom,
    room: ImpactWorkspace,
) -> None:
    """
    Play a stroke at each of many tables, or simulate them without, one after the other.

    A stroke ends as its strike; if that went well, as its run; if that went well, as its accuracy
    says. A checked stroke whose ball meets rounded jaws of pockets is played again, finer: each
    jaw magnifies an error a few hundred times. The change then tells the error.

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
    for number in range(len(tables.ends)):
        end, status = tables.ends[number], OK
        s = motion.Simulation(
            simulation.balls,
            simulation.collisions,
            end,
            simulation.rebound[0],
            tables.segments,
            tables.events,
            rules=window.rules,
            cue=simulation.cue[0],
        )
        run_table(layout, s, tables, strokes, number, tolerance, window, room)
        if len(tables.cues) > 0:
            cue, ball = tables.cues[number], tables.balls[number * len(s.balls)]
            status = cue.status
            if strokes.checked:
                end.error = estimated_error(layout, cue, ball, tolerance)
                if end.jaws_met > 0:
                    x, y, z = ball.position[0], ball.position[1], ball.position[2]
                    finer = placement.FINER * tolerance
                    run_table(layout, s, tables, strokes, number, finer, window, room)
                    if ball.first_contact == motion.NOTHING:
                        x, y, z = ball.position[0] - x, ball.position[1] - y, ball.position[2] - z
                        end.error = max(
                            end.error, placement.LEFT * math.sqrt(x * x + y * y + z * z)
                        )
                    if cue.status != TOLERANCE_NOT_REACHED:  # as fine as an impact can be solved
                        status = cue.status
        if status in (OK, INFINITE_SEQUENCE):
            if end.run_status != OK:
                status = end.run_status
            elif end.error > tolerance:
                status = TOLERANCE_NOT_REACHED
        end.status = status


# Hops after impacts with balls and cushions that move a ball by less [m] are left out. Friction
# between balls makes one at nearly every impact, a third of a millimetre high at most.
DEFAULT_TOLERANCE = 2e-3
DEFAULT_MAX_EVENTS = 20_000  # of a table
# Room at first, for each of all balls and two: segments and events of a run, and segments of a
# table of a batch. Most have fewer.
CAPACITY, _CAPACITY_IN_BATCH = 32, 8
_PHASE_CAPACITY = 64  # room at first for phases of a strike, times its contacts


class TableTask(NamedTuple):
    """
    Tables to be simulated.

    Attributes
    ----------
    params, table : BallClothParams, TableParams
    starts : (tables, balls) array of TableBall
        With strokes, one table may stand for all.
    tolerance : float
        See `play_tables` [m].
    hop_tolerance : float
        See `TableNumbers` [m].
    max_events : int
        A run that takes more ends with BUDGET_EXCEEDED.
    cue : CueParams
        Of the cues.
    strokes : Strokes, optional
        Without them, there are no cues.
    rules : (balls,) array of BallRule, optional
        With these, each run ends as soon as it is decided.
    fast_rebounds : bool
        Rebounds of lying balls are interpolated (cushion_models.py): a fiftieth of the cost, and
        an error of 0.5 % of the ball's speed in 95 % of rebounds. Interpreted code solves all.
    until : float
        Time at which runs end if balls still move [s], see `RunLimits`.
    times : tuple of float
        Times at which the places of the balls are noted [s], ascending.

    """

    params: geometry.BallClothParams
    table: geometry.TableParams
    starts: NDArray[np.void]
    tolerance: float
    hop_tolerance: float = DEFAULT_TOLERANCE
    max_events: int = DEFAULT_MAX_EVENTS
    cue: CueParams = NO_CUE
    strokes: placement.Strokes | None = None
    rules: NDArray[np.void] | None = None
    fast_rebounds: bool = False
    until: float = math.inf
    times: tuple[float, ...] = ()

    @property
    def tables(self) -> int:
        """Number of tables."""
        return len(self.starts if self.strokes is None else self.strokes.normals)


class BatchRecording(NamedTuple):
    """
    Simulated tables.

    Attributes
    ----------
    balls : (tables, balls) array of TableBall
    tables : (tables,) array of TableOutcome
    segments : (segments,) array of SegmentRecord
        Of all tables, one after the other, as far as there was room.
    events : EventLog
        Of the last table, as far as there was room.
    places : (tables, balls, times, 3) float array
        At the times of the task [m].
    cues : (tables,) array of CueRecord, or none
        After their strikes.
    log : (phases, N) array of PhaseLog
        The strike on the last table with its N contacts, as far as there was room.
    losses : (N, 2) float array
        At these contacts, to restitution and to friction [J].

    """

    balls: NDArray[np.void]
    tables: NDArray[np.void]
    segments: NDArray[np.void]
    events: EventLog
    places: NDArray[np.float64]
    cues: NDArray[np.void]
    log: NDArray[np.void]
    losses: NDArray[np.float64]


# Of a `BatchRecording`: those that have a row for each table.
COLUMNS = 'balls', 'tables', 'places', 'cues'


def run_with_events(task: TableTask) -> BatchRecording:
    """Simulate one table in this thread, recording all that happens; see `run_tables`."""
    capacity, phases = CAPACITY * (2 + task.starts.shape[1]), _PHASE_CAPACITY
    while True:
        played = run_tables(task, capacity, capacity, phases)
        needed = max(int(played.tables[name][-1]) for name in ('segments', 'events'))
        logged = int(played.cues['phases'][-1]) * len(played.losses) if len(played.cues) else 0
        if needed <= capacity and logged <= phases:
            return played
        while needed > capacity:
            capacity *= 2
        while logged > phases:
            phases *= 2


def run_recorded(task: TableTask) -> BatchRecording:
    """Simulate tables in this thread, recording all motion."""
    tables, balls = task.tables, task.starts.shape[1]
    capacity = _CAPACITY_IN_BATCH * tables * (2 + balls)
    while True:
        played = run_tables(task, capacity)
        needed = int(played.tables['segments'][-1]) if tables else 0
        if needed <= capacity:
            return played
        capacity = needed


Rooms: TypeAlias = tuple[motion.SimulationRoom, ImpactWorkspace]


class _Thread(threading.local):
    """Rooms of this thread: to make them anew takes longer than a table of one ball."""

    def __init__(self) -> None:
        self.kept: dict[tuple[Storage, int, bool, int, int], Rooms] = {}

    def rooms(
        self, storage: Storage, balls: int, with_cue: bool, participants: int, phases: int
    ) -> Rooms:
        """Take rooms for so many balls, and records of impacts of these lengths."""
        kept = self.kept.pop((storage, balls, with_cue, participants, phases), None)
        if kept is not None:
            return kept
        room = room_for(storage, balls, with_cue)
        if participants:
            most = storage.array(np.zeros((participants, 2), np.int64))
            room = room._replace(participants=most)
        if phases:
            log = storage.unset(PhaseLog, phases)
            room = room._replace(results=room.results._replace(log=log))
        return motion.room_for_simulation(storage, balls), room


_thread = _Thread()
NO_RULES = ROWS.records(motion.BallRule, 0)
NO_LOG, NO_LOSSES = ROWS.records(PhaseLog, 0).reshape(0, 2), np.zeros((2, 2))


def run_tables(
    task: TableTask, segments: int = 0, events: int = 0, phases: int = 0
) -> BatchRecording:
    """
    Simulate tables in this thread.

    Motion is recorded as far as there is room for segments of all tables, and for events of the
    last one, and for phases of its strike, times contacts.
    """
    run = play_tables.current()
    storage = run.storage
    tables, count, with_cue = task.tables, task.starts.shape[1], task.strokes is not None
    # each participant of an impact begins a segment
    key = storage, count, with_cue, segments if events else 0, phases
    _, room = rooms = _thread.rooms(*key)
    played, _, _, window, *_ = arguments = packed(task, storage, rooms, segments, events)
    run(*arguments)
    ends = as_rows(motion.TableOutcome, played.ends)
    recorded, logged, taken = (
        int(ends[name][-1]) if tables else 0 for name in ('segments', 'events', 'participants')
    )
    cues = as_rows(CueRecord, played.cues)
    log, losses = strike_details(cues, room) if phases and len(cues) else (NO_LOG, NO_LOSSES)
    _thread.kept[key] = rooms  # not after an exception
    return BatchRecording(
        as_rows(motion.TableBall, played.balls).reshape(tables, count),
        ends,
        as_rows(motion.SegmentRecord, played.segments[:recorded]),
        EventLog(
            as_rows(motion.EventRecord, played.events[:logged]),
            np.array(room.participants[:taken], np.int64).reshape(-1, 2),
        ),
        np.asarray(window.places).reshape(tables, count, len(task.times), 3),
        cues,
        log,
        losses,
    )


def packed(
    task: TableTask, storage: Storage, rooms: Rooms, segments: int = 0, events: int = 0
) -> tuple[Any, ...]:
    """Return the arguments of `play_tables`, see `run_tables`."""
    tables, count, with_cue = task.tables, task.starts.shape[1], task.strokes is not None
    layout = lay_out(
        storage, task.params, task.table, task.hop_tolerance, task.fast_rebounds, cue=task.cue
    )
    played = Tables(
        storage.from_rows(motion.TableBall, task.starts.reshape(-1)),
        storage.records(CueRecord, tables if with_cue else 0),
        storage.records(motion.TableBall, tables * count),
        storage.records(motion.TableOutcome, tables),
        storage.unset(motion.SegmentRecord, segments),
        storage.unset(motion.EventRecord, events),
    )
    strokes = (task.strokes or placement.NO_STROKES).stored(storage, count)
    rules = storage.from_rows(motion.BallRule, NO_RULES if task.rules is None else task.rules)
    places = storage.zeros(tables, count, len(task.times), 3)
    times = storage.array(np.array(task.times, float))
    window = RunLimits(task.until, task.max_events, rules, times, places)
    return played, strokes, task.tolerance, window, layout, *rooms


def strike_details(
    cues: NDArray[np.void], room: ImpactWorkspace
) -> tuple[NDArray[np.void], NDArray[np.float64]]:
    """Return the log and the losses of the last strike, see `BatchRecording`."""
    phases, count = int(cues['phases'][-1]), int(cues['contacts'][-1])
    contacts = max(count, 2)  # of tip and cloth, also if the stroke was refused
    log, losses = as_rows(PhaseLog, room.results.log), np.zeros((contacts, 2))
    losses[:count] = np.reshape(room.losses[:count], (count, 2))
    logged = min(phases, len(log) // contacts) * contacts
    return log[:logged].reshape(-1, contacts).copy(), losses


def joined(parts: list[BatchRecording], order: NDArray[np.int64] | None = None) -> BatchRecording:
    """Put tables that were simulated in parts one after the other, or in an order; no motion."""
    if len(parts) == 1:
        return parts[0]
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS
    }
    if order is not None:
        # Without strokes there are no rows of cues.
        columns = {name: rows[order[: len(rows)]] for name, rows in columns.items()}
    return parts[0]._replace(**columns)


T = TypeVar('T')

LARGEST_PART = 1000
"""Rows that one thread does at once. Between two parts, Ctrl+C is answered."""


def in_threads(work: Callable[[slice], T], count: int, workers: int | None = None) -> list[T]:
    """
    Divide a batch among threads; return what each part gave, in order, at least of one part.

    `work` must not call this function: its thread would wait for itself.

    Parameters
    ----------
    work : callable
        Does the rows of a slice.
    count : int
        Rows of the batch.
    workers : int, optional
        Threads; by default as many as there are cores.

    """
    threads = workers or os.cpu_count() or 1
    count = max(count, 1)
    small = math.ceil(count / (8 * threads))  # because rows differ in cost
    size = LARGEST_PART if threads == 1 else small
    parts = [slice(i, i + size) for i in range(0, count, size)]
    if threads == 1 or len(parts) <= 1:
        return [work(part) for part in parts]
    return list(_pool(threads, os.getpid()).map(work, parts))


@cache
def _pool(threads: int, process: int) -> ThreadPoolExecutor:
    """Return threads of this process that stay, because each of them keeps its rooms."""
    del process  # a process that is forked has none of the threads of its parent
    return ThreadPoolExecutor(threads, 'batch')
