"""Batches of tables on all cores: as compiled code simulates them, and what it records of them."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
import math
import os
import threading
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.state import PhaseLog
from billiard_shot.records import as_rows, ROWS, Storage
from billiard_shot.table.contacts.cluster import room_for
from billiard_shot.table.contacts.gather import ImpactWorkspace
from billiard_shot.table.model.cue import CueParams, CueRecord, NO_CUE
from billiard_shot.table.model.geometry import BallClothParams, TableParams
from billiard_shot.table.model.motion import (
    BallRule,
    BallStart,
    EventRecord,
    room_for_simulation,
    RunProgress,
    SegmentRecord,
    SimulationRoom,
)
from billiard_shot.table.run.event_loop import RunLimits
from billiard_shot.table.run.layout import lay_out
from billiard_shot.table.run.play_tables import BallOutcome, play_tables, TableOutcome, Tables
from billiard_shot.table.run.results import EventLog
from billiard_shot.table.strike.placement import NO_STROKES, Strokes

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
    starts : (tables, balls) array of BallStart
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

    params: BallClothParams
    table: TableParams
    starts: NDArray[np.void]
    tolerance: float
    hop_tolerance: float = DEFAULT_TOLERANCE
    max_events: int = DEFAULT_MAX_EVENTS
    cue: CueParams = NO_CUE
    strokes: Strokes | None = None
    rules: NDArray[np.void] | None = None
    fast_rebounds: bool = False
    until: float = math.inf
    times: tuple[float, ...] = ()

    @property
    def tables(self) -> int:
        """Number of tables."""
        return len(self.starts if self.strokes is None else self.strokes.normals)

    def part(self, part: slice) -> 'TableTask':
        """Return some of the tables, on which there are no strokes."""
        return self._replace(starts=self.starts[part])


class BatchRecording(NamedTuple):
    """
    Simulated tables.

    Attributes
    ----------
    balls : (tables, balls) array of BallOutcome
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
    discontinuity : (tables,) float array
        How far the end of the trajectory after a stroke jumps [m], see shot/play.py;
        else 0.

    """

    balls: NDArray[np.void]
    tables: NDArray[np.void]
    segments: NDArray[np.void]
    events: EventLog
    places: NDArray[np.float64]
    cues: NDArray[np.void]
    log: NDArray[np.void]
    losses: NDArray[np.float64]
    discontinuity: NDArray[np.float64]


# Of a `BatchRecording`: those that have a row for each table.
COLUMNS = 'balls', 'tables', 'places', 'cues', 'discontinuity'


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


Rooms: TypeAlias = tuple[SimulationRoom, ImpactWorkspace]


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
        return room_for_simulation(storage, balls), room


_thread = _Thread()
NO_RULES = ROWS.records(BallRule, 0)
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
    simulation, room = rooms = _thread.rooms(*key)
    played, _, _, window, *_ = arguments = packed(task, storage, rooms, segments, events)
    run(*arguments)
    progress = as_rows(RunProgress, simulation.progress)[0]  # by names: attributes take 2 us each
    logged, taken = int(progress['events']), int(progress['participants'])
    cues = as_rows(CueRecord, played.cues)
    log, losses = strike_details(cues, room) if phases and len(cues) else (NO_LOG, NO_LOSSES)
    _thread.kept[key] = rooms  # not after an exception
    return BatchRecording(
        as_rows(BallOutcome, played.balls).reshape(tables, count),
        as_rows(TableOutcome, played.ends),
        as_rows(SegmentRecord, played.segments[: int(progress['segments'])]),
        EventLog(
            as_rows(EventRecord, played.events[:logged]),
            np.array(room.participants[:taken], np.int64).reshape(-1, 2),
        ),
        np.asarray(window.places).reshape(tables, count, len(task.times), 3),
        cues,
        log,
        losses,
        discontinuity=np.zeros(tables),
    )


def packed(
    task: TableTask,
    storage: Storage,
    rooms: Rooms,
    segments: int = 0,
    events: int = 0,
) -> tuple[Any, ...]:
    """Return the arguments of `play_tables`, see `run_tables`."""
    tables, count, with_cue = task.tables, task.starts.shape[1], task.strokes is not None
    layout = lay_out(
        storage, task.params, task.table, task.hop_tolerance, task.fast_rebounds, cue=task.cue
    )
    played = Tables(
        storage.from_rows(BallStart, task.starts.reshape(-1)),
        storage.records(CueRecord, tables if with_cue else 0),
        storage.records(BallOutcome, tables * count),
        storage.records(TableOutcome, tables),
        storage.unset(SegmentRecord, segments),
        storage.unset(EventRecord, events),
    )
    strokes = (task.strokes or NO_STROKES).stored(storage, count)
    rules = storage.from_rows(BallRule, NO_RULES if task.rules is None else task.rules)
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
