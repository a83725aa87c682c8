"""`simulate`: the table alone, from the balls' states to rest; `simulate_batch`: many of those."""

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from functools import cache, cached_property
import math
import os
import threading
from time import perf_counter
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot import machine_code
from billiard_shot.impact.kernel import solve_collisions
from billiard_shot.impact.state import PhaseLog
from billiard_shot.records import as_rows, ROWS, Storage
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.parameters import rows_of_parameters
from billiard_shot.scene.values import as_floats, LARGEST, positive, whole
from billiard_shot.status import Status
from billiard_shot.table.cluster import room_for
from billiard_shot.table.cue import CueParams, CueRecord, NO_CUE
from billiard_shot.table.data_frame import data_frame
from billiard_shot.table.effects import params_on_table
from billiard_shot.table.event_loop import (
    BallOutcome,
    Beginnings,
    simulate_tables,
    TableOutcome,
    Window,
)
from billiard_shot.table.gather import ImpactRoom
from billiard_shot.table.geometry import lay_out
from billiard_shot.table.initial_states import (
    BallStart,
    in_cushions,
    States,
    validated_starts,
    VECTORS,
)
from billiard_shot.table.motion import Motion, NOTHING, SegmentRecord
from billiard_shot.table.params import BallClothParams, TableParams
from billiard_shot.table.run import EventLog, POCKET_NAMES, TableRun
from billiard_shot.table.simulation_state import (
    BallRule,
    EventRecord,
    room_for_simulation,
    RunProgress,
    SimulationRoom,
)
from billiard_shot.table.table_states import ManyStates, table_states, TableStates
from billiard_shot.table.words import count_in_words, plural

T = TypeVar('T')

# Hops after impacts with balls and cushions that move a ball by less [m] are left out. Friction
# between balls makes one at nearly every impact, a third of a millimetre high at most.
DEFAULT_TOLERANCE = 2e-3
DEFAULT_MAX_EVENTS = 20_000  # of a table
INTERPRETED_AT_MOST = 100  # tables or strokes: a larger batch waits for machine code
# Room at first, for each of all balls and two: segments and events of a run, and segments of a
# table of a batch. Most have fewer.
_CAPACITY, _CAPACITY_IN_BATCH = 32, 8
_PHASE_CAPACITY = 64  # room at first for phases of a strike, times its contacts


class TableTask(NamedTuple):
    """
    Tables to be simulated.

    Attributes
    ----------
    params, table : BallClothParams, TableParams
    starts : (tables, balls) array of BallStart
    tolerance, hop_tolerance : float
        See `TableNumbers` [m].
    max_events : int
        A run that takes more ends with BUDGET_EXCEEDED.
    cue : CueParams
        Of the cues.
    cues : (tables,) array of CueRecord, optional
        Without them, there are no cues.
    rules : (balls,) array of BallRule, optional
        With these, each run ends as soon as it is decided.
    fast_rebounds : bool
        Rebounds of lying balls are interpolated (rebound_table.py): a fiftieth of the cost, and an
        error of 0.5 % of the ball's speed in 95 % of rebounds. Interpreted code solves all.
    until : float
        Time at which runs end if balls still move [s]. 0: only strikes are simulated.
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
    cues: NDArray[np.void] | None = None
    rules: NDArray[np.void] | None = None
    fast_rebounds: bool = False
    until: float = math.inf
    times: tuple[float, ...] = ()

    def part(self, part: slice) -> 'TableTask':
        """Return some of the tables."""
        return self._replace(
            starts=self.starts[part],
            cues=None if self.cues is None else self.cues[part],
        )


def simulate(
    scene: SceneLike,
    states: States,
    tolerance: float = DEFAULT_TOLERANCE,
    max_events: int = DEFAULT_MAX_EVENTS,
    *,
    until: float | None = None,
) -> TableRun:
    """
    Simulate all that balls do on a table, without a stroke, until they rest.

    Parameters
    ----------
    scene : Scene, str or Path
        Its `table`; without one the cloth is endless. `balls` does not count here. A name or path
        is read as by `Scene.load`.
    states : mapping of str to BallState
        The balls by name: position (3,) [m], velocity (3,) [m/s], spin (3,) [rad/s]; numbers of
        at most 1e12.
    tolerance : float
        Hops of a ball that move it by less are left out [m], above 0.
    max_events : int
        A run that takes more ends with BUDGET_EXCEEDED.
    until : float, optional
        Time at which the run ends, even if balls still move [s], above 0.

    Returns
    -------
    TableRun
        `status`: OK, OFF_TABLE (a ball left it), NEVER_RESTS or BUDGET_EXCEEDED; or where several
        balls at once could not be solved, that of their collision: it ends there.

    Raises
    ------
    ValueError
        Naming the ball, field and value that makes no sense.

    """
    scene = Scene.load(scene)
    tolerance = positive('tolerance', tolerance, 'm')
    max_events = whole('max_events', max_events, 1)
    starts = validated_starts(scene, states)
    end = math.inf if until is None else positive('until', until, 's')
    task = TableTask(*params_on_table(scene), starts, tolerance, tolerance, max_events, until=end)
    return run_one(task, tuple(states))


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
    status : (tables,) int array
        Status: of the table or, if a stroke is played on it, of both (shot/play.py).
    error, discontinuity : (tables,) float arrays
        Of a stroke that is played accurately: estimate of the error of the trajectory, and how far
        its end jumps [m]; else 0.

    """

    balls: NDArray[np.void]
    tables: NDArray[np.void]
    segments: NDArray[np.void]
    events: EventLog
    places: NDArray[np.float64]
    cues: NDArray[np.void]
    log: NDArray[np.void]
    losses: NDArray[np.float64]
    status: NDArray[np.int64]
    error: NDArray[np.float64]
    discontinuity: NDArray[np.float64]


# Of a `BatchRecording`: those that have a row for each table.
COLUMNS = 'balls', 'tables', 'places', 'cues', 'status', 'error', 'discontinuity'


def run_one(task: TableTask, names: tuple[str, ...]) -> TableRun:
    """Simulate one table, whose balls have these names, with all that happens."""
    begin = perf_counter()
    played = run_with_events(task)
    return run_of(played, names, perf_counter() - begin)


def run_of(played: BatchRecording, names: tuple[str, ...], wall_time: float) -> TableRun:
    """Return the recording of one table, whose balls have these names, as people use it."""
    end, balls = played.tables, played.balls[0]
    places = np.empty((len(balls), 2), np.int64)
    places[:, 0], places[:, 1] = balls['pocket'], balls['first_contact']
    return TableRun(
        names,
        Status(int(end['status'][0])),
        float(end['duration'][0]),
        wall_time,
        int(end['searches'][0]),
        played.segments,
        _events=played.events,
        _places=places,
        jaws_met=int(end['jaws_met'][0]),
    )


def run_with_events(task: TableTask) -> BatchRecording:
    """Simulate one table in this thread, recording all that happens; see `run_tables`."""
    segments = events = _CAPACITY * (2 + task.starts.shape[1])
    phases = _PHASE_CAPACITY
    while True:
        played = run_tables(task, segments, events, phases)
        needed, happened = int(played.tables['segments'][-1]), int(played.tables['events'][-1])
        logged = int(played.cues['phases'][-1]) * len(played.losses) if len(played.cues) else 0
        if needed <= segments and happened <= events and logged <= phases:
            return played
        segments, events, phases = needed, happened, logged


def run_recorded(task: TableTask) -> BatchRecording:
    """Simulate tables in this thread, recording all motion."""
    tables, balls = task.starts.shape
    capacity = _CAPACITY_IN_BATCH * tables * (2 + balls)
    while True:
        played = run_tables(task, capacity)
        needed = int(played.tables['segments'][-1]) if tables else 0
        if needed <= capacity:
            return played
        capacity = needed


class _Thread(threading.local):
    """Rooms of this thread: to make them anew takes longer than a table of one ball."""

    def __init__(self) -> None:
        self.kept: dict[tuple[Storage, int, bool], tuple[SimulationRoom, ImpactRoom]] = {}

    def rooms(
        self, storage: Storage, balls: int, with_cue: bool
    ) -> tuple[SimulationRoom, ImpactRoom]:
        """Take rooms for a number of balls; their contents are those of the last table."""
        kept = self.kept.pop((storage, balls, with_cue), None)
        if kept is not None:
            return kept
        return room_for_simulation(storage, balls), room_for(storage, balls, with_cue)


_thread = _Thread()
NO_CUES, NO_RULES = ROWS.records(CueRecord, 0), ROWS.records(BallRule, 0)
NO_LOG, NO_LOSSES = ROWS.records(PhaseLog, 0).reshape(0, 2), np.zeros((2, 2))


def run_tables(
    task: TableTask, segments: int = 0, events: int = 0, phases: int = 0
) -> BatchRecording:
    """
    Simulate tables in this thread.

    Motion is recorded as far as there is room for segments of all tables, and for events of the
    last one, and for phases of its strike, times contacts.
    """
    run = simulate_tables.current()
    storage = run.storage
    tables, count = task.starts.shape
    cues = task.cues
    layout = lay_out(
        storage,
        task.params,
        task.table,
        task.tolerance,
        task.hop_tolerance,
        task.fast_rebounds,
        cue=task.cue,
    )
    with_cue = cues is not None
    simulation, room = kept = _thread.rooms(storage, count, with_cue)
    simulation = simulation._replace(
        segments=storage.unset(SegmentRecord, segments),
        events=storage.unset(EventRecord, events),
        rules=storage.from_rows(BallRule, NO_RULES if task.rules is None else task.rules),
    )
    if events:
        most = np.zeros((segments, 2), np.int64)  # each participant begins a segment
        room = room._replace(participants=storage.array(most))
    if phases:
        log = storage.unset(PhaseLog, phases)
        room = room._replace(results=room.results._replace(log=log))
    changed = NO_CUES if cues is None else cues.copy()  # a strike writes into its cue
    beginnings = Beginnings(
        storage.from_rows(BallStart, task.starts.reshape(-1)),
        storage.from_rows(CueRecord, changed),
    )
    balls = storage.records(BallOutcome, tables * count)
    ends = storage.records(TableOutcome, tables)
    places = storage.zeros(tables, count, len(task.times), 3)
    window = Window(task.until, storage.array(np.array(task.times, float)), places)
    solver = solve_collisions.as_argument(storage)
    run(layout, simulation, beginnings, task.max_events, room, balls, ends, solver, window)
    progress = as_rows(RunProgress, simulation.progress)[0]  # by names: attributes take 2 us each
    logged, taken = int(progress['events']), int(progress['participants'])
    cues = as_rows(CueRecord, beginnings.cues)
    log, losses = strike_details(cues, room) if phases and len(cues) else (NO_LOG, NO_LOSSES)
    _thread.kept[storage, count, with_cue] = kept  # not after an exception
    outcomes = as_rows(TableOutcome, ends)
    return BatchRecording(
        as_rows(BallOutcome, balls).reshape(tables, count),
        outcomes,
        as_rows(SegmentRecord, simulation.segments[: int(progress['segments'])]),
        EventLog(
            as_rows(EventRecord, simulation.events[:logged]),
            np.array(room.participants[:taken], np.int64).reshape(-1, 2),
        ),
        np.asarray(places).reshape(tables, count, len(task.times), 3),
        cues,
        log,
        losses,
        outcomes['status'],
        error=np.zeros(tables),
        discontinuity=np.zeros(tables),
    )


def strike_details(
    cues: NDArray[np.void], room: ImpactRoom
) -> tuple[NDArray[np.void], NDArray[np.float64]]:
    """Return the log and the losses of the last strike, see `BatchRecording`."""
    phases, count = int(cues['phases'][-1]), int(cues['contacts'][-1])
    contacts = max(count, 2)  # of tip and cloth, also if the stroke was refused
    log, losses = as_rows(PhaseLog, room.results.log), np.zeros((contacts, 2))
    losses[:count] = np.reshape(room.losses[:count], (count, 2))
    logged = min(phases, len(log) // contacts) * contacts
    return log[:logged].reshape(-1, contacts), losses


@dataclass(frozen=True, eq=False)
class TableBatch:
    """Runs of many tables; row by row what `simulate` gives. Balls in the order of `names`."""

    names: tuple[str, ...]
    final_position: NDArray[np.float64]  # (tables, balls, 3) m, of each ball
    motion: NDArray[np.uint8]  # (tables, balls) a Motion: REST, POCKETED, ABSENT ...
    pocket: NDArray[np.int64]  # (tables, balls) index in POCKET_NAMES, -1: in none
    first_met: NDArray[np.int64]  # (tables, balls) index of the first ball each met, -1: none
    duration: NDArray[np.float64]  # (tables,) s until all rest
    status: NDArray[np.uint16]  # (tables,) Status
    events: NDArray[np.int64]  # (tables,) how many there were
    searches: NDArray[np.int64]  # (tables,) how many contacts were looked for
    cue_hits: NDArray[np.int64]  # (tables,) how often the cue met ball 0 after a strike
    miscue: NDArray[np.bool_]  # (tables,) the tip still slid when it left ball 0 after a strike
    jaws_met: NDArray[np.int64]  # (tables,) rounded jaws that ball 0 met before another ball
    rest_time: NDArray[np.float64]  # (tables, balls) s since when it rests, or is off the table
    cushions: NDArray[np.int64]  # (tables, balls) straight cushions that each ball met
    last_cushion: NDArray[np.float64]  # (tables, balls) s, of a cushion or a jaw; -inf: none
    met_time: NDArray[np.float64]  # (tables, balls) s, when ball 0 met each ball first; inf: never
    met_after: NDArray[np.int64]  # (tables, balls) straight cushions that ball 0 had met by then
    position_at: NDArray[np.float64]  # (tables, balls, times, 3) m, at the times asked for

    @property
    def states(self) -> TableStates:
        """The balls as they rest on the table, without those that fell or left it."""
        on_table = self.motion < Motion.POCKETED
        return TableStates(self.names, self.final_position, present=on_table)

    @property
    def first_contact_time(self) -> NDArray[np.float64]:
        """When ball 0 met another ball (tables,) [s]; infinite if it met none."""
        first: NDArray[np.float64] = self.met_time.min(axis=1)
        return first

    @property
    def to_cushion(self) -> NDArray[np.bool_]:
        """Whether each ball (tables, balls) met a cushion or jaw after ball 0 met another ball."""
        after: NDArray[np.bool_] = self.last_cushion > self.first_contact_time[:, np.newaxis]
        return after

    @property
    def off_table(self) -> NDArray[np.bool_]:
        """Whether each ball (tables, balls) left the table."""
        off: NDArray[np.bool_] = self.motion == Motion.OFF_TABLE
        return off

    @cached_property
    def pocketed(self) -> tuple[dict[str, str], ...]:
        """For each table the balls that fell, in the order of time, and the pockets."""
        fallen: list[dict[str, str]] = [{} for _ in range(len(self.status))]
        tables, balls = np.nonzero(self.pocket != NOTHING)
        for k in np.lexsort((self.rest_time[tables, balls], tables)).tolist():
            t, i = int(tables[k]), int(balls[k])
            fallen[t][self.names[i]] = POCKET_NAMES[self.pocket[t, i]]
        return tuple(fallen)

    def to_frame(self) -> Any:
        """
        Make a pandas DataFrame with a row for each table; places in m, times in s.

        `pocketed`, `off_table` and `to_cushion` are tuples of names, `first_contact` is a name or
        None, and `first_contact_time` is NaN without a first contact.

        Raises
        ------
        ValueError
            If pandas is not installed.

        """
        return data_frame(
            {
                'status': [Status(each).name for each in self.status.tolist()],
                'duration': self.duration,
                **self.columns(),
            }
        )

    def columns(self) -> dict[str, Any]:
        """Return the columns of `to_frame` that tell what the balls did."""
        names = np.array([*self.names, None], object)
        places = {
            f'{name}_{x}': self.final_position[:, i, k]
            for i, name in enumerate(self.names)
            for k, x in enumerate('xy')
        }
        return {
            'first_contact': names[self.first_met[:, 0]],
            'first_contact_time': self.first_contact_time,
            'pocketed': [tuple(each) for each in self.pocketed],
            'off_table': self._listed(self.off_table),
            'to_cushion': self._listed(self.to_cushion),
            'cushions': self.cushions[:, 0],
            'cue_hits': self.cue_hits,
            'miscue': self.miscue,
            **places,
        }

    def _listed(self, which: NDArray[np.bool_]) -> list[tuple[str, ...]]:
        return [
            tuple(name for name, there in zip(self.names, row, strict=True) if there)
            for row in which.tolist()
        ]

    def __repr__(self) -> str:
        balls = plural(len(self.names), 'ball')
        return f'TableBatch({balls}, {count_in_words(self.status, "table", self.miscue)})'


def simulate_batch(
    scene: SceneLike,
    states: ManyStates,
    tolerance: float = DEFAULT_TOLERANCE,
    max_events: int = DEFAULT_MAX_EVENTS,
    workers: int | None = None,
    *,
    present: ArrayLike | None = None,
    until: float | None = None,
    at: ArrayLike | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
) -> TableBatch:
    """
    Simulate many tables at once, on all cores.

    Parameters
    ----------
    scene, tolerance, max_events
        As for `simulate`.
    states : TableStates, mapping of str to BallState, or sequence of such mappings
        One mapping whose arrays are (tables, 3), or (3,) for all tables alike; or a mapping for
        each table, with the balls that this table has. A row that cannot be (not finite or too
        large, overlapping balls, a ball in a cushion) gets the status INVALID_REQUEST; `simulate`
        says why.
    workers : int, optional
        Threads; by default as many as there are cores.
    present : (tables, balls) array_like of bool, optional
        If `states` is one mapping: whether a table has a ball; by default all tables have all. A
        ball that a table does not have ends with the motion ABSENT.
    until : float, optional
        As for `simulate`.
    at : (times,) array_like, optional
        Times for which `position_at` of the result has the places of the balls [s], ascending, at
        least 0.
    parameters : mapping of str to (tables,) array_like, optional
        Numbers of the scene, see `Scene.parameters`, that differ from table to table. Tables with
        the same numbers are simulated together: each set of numbers takes some milliseconds.

    Raises
    ------
    ValueError
        If an argument makes no sense.

    """
    scene = Scene.load(scene)
    tolerance = positive('tolerance', tolerance, 'm')
    max_events = whole('max_events', max_events, 1)
    if workers is not None:
        workers = whole('workers', workers, 1)
    end = math.inf if until is None else positive('until', until, 's')
    tables = table_states(states, present)
    times = _times(at)
    if len(tables) > INTERPRETED_AT_MOST:
        machine_code.require()

    def simulate_rows(scene: Scene, rows: TableStates) -> TableBatch:
        starts = rows.starts()
        for field in VECTORS:
            starts[field][np.abs(starts[field]) > LARGEST] = np.nan  # compiled code refuses it
        for t, i, _ in in_cushions(scene, starts):
            starts['position'][t, i] = np.nan
        task = TableTask(
            *params_on_table(scene),
            starts,
            tolerance,
            tolerance,
            max_events,
            until=end,
            times=times,
        )
        return run_many(task, rows.names, workers)

    if not parameters:
        return simulate_rows(scene, tables)
    names, values = rows_of_parameters(parameters, len(tables))
    sets, which = np.unique(values, axis=0, return_inverse=True)
    which = which.ravel()  # of another shape in some versions of NumPy
    parts = [
        simulate_rows(scene.with_parameters(names, row), tables.take(which == number))
        for number, row in enumerate(sets)
    ]
    if not parts:
        return simulate_rows(scene, tables)
    order = np.argsort(np.argsort(which, kind='stable'), kind='stable')
    return TableBatch(
        **{
            each.name: np.concatenate([getattr(part, each.name) for part in parts])[order]
            for each in fields(TableBatch)
            if each.name != 'names'
        },
        names=tables.names,
    )


def _times(at: ArrayLike | None) -> tuple[float, ...]:
    """Read times that must be ascending [s]."""
    times = np.zeros(0) if at is None else as_floats(at)
    wrong = times.ndim != 1 or not np.isfinite(times).all() or (times < 0.0).any()
    if wrong or (at is not None and not len(times)) or (np.diff(times) < 0.0).any():
        raise ValueError(f'at must be ascending times, at least 0, got {at!r} (s)')
    return tuple(times.tolist())


def in_threads(work: Callable[[slice], T], count: int, workers: int | None = None) -> list[T]:
    """
    Divide a batch among threads; return what each part gave, in order.

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
    size = max(1, math.ceil(count / (8 * threads)))  # small parts, because rows differ in cost
    parts = [slice(i, i + size) for i in range(0, count, size)]
    if threads == 1 or len(parts) <= 1:
        return [work(part) for part in parts]
    return list(_pool(threads, os.getpid()).map(work, parts))


@cache
def _pool(threads: int, process: int) -> ThreadPoolExecutor:
    """Return threads of this process that stay, because each of them keeps its rooms."""
    del process  # a process that is forked has none of the threads of its parent
    return ThreadPoolExecutor(threads, 'batch')


def run_many(task: TableTask, names: tuple[str, ...], workers: int | None = None) -> TableBatch:
    """Simulate tables, whose balls have these names, on all cores."""

    def simulate_part(part: slice) -> BatchRecording:
        return run_tables(task.part(part))

    parts = in_threads(simulate_part, len(task.starts), workers)
    parts = parts or [simulate_part(slice(0, 0))]
    return batch_of(joined(parts), names)


def joined(parts: list[BatchRecording]) -> BatchRecording:
    """Put tables one after the other that were simulated in parts, without their motion."""
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in COLUMNS
    }
    return parts[0]._replace(**columns)


def batch_of(played: BatchRecording, names: tuple[str, ...]) -> TableBatch:
    """Return simulated tables, whose balls have these names, as people use them."""
    balls, tables, cues = played.balls, played.tables, played.cues
    return TableBatch(
        names=names,
        final_position=balls['position'],
        motion=balls['motion'].astype(np.uint8),
        pocket=balls['pocket'],
        first_met=balls['first_contact'],
        duration=tables['duration'],
        status=played.status.astype(np.uint16),
        events=tables['events'],
        searches=tables['searches'],
        cue_hits=tables['cue_hits'],
        miscue=cues['miscue'] if len(cues) else np.zeros(len(tables), np.bool_),
        jaws_met=tables['jaws_met'],
        rest_time=balls['time'],
        cushions=balls['cushions'],
        last_cushion=balls['last_edge'],
        met_time=balls['met_time'],
        met_after=balls['met_after'],
        position_at=played.places,
    )
