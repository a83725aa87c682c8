"""`simulate`: the table alone, from the balls' states to rest; `simulate_batch`: many of those."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
import math
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from billiard_shot.notebook import Tabular
from billiard_shot.records import column
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.fields import as_floats, LARGEST, positive, whole
from billiard_shot.scene.scene import rows_of_parameters
from billiard_shot.status import Status
from billiard_shot.table.model.motion import LEFT_TABLE, NOTHING, POCKETED
from billiard_shot.table.run.effects import params_on_table
from billiard_shot.table.run.results import count_in_words, plural, POCKET_NAMES, TableRun
from billiard_shot.table.run.states import (
    in_cushions,
    ManyStates,
    States,
    table_states,
    TableStates,
    validated_starts,
    VECTORS,
)
from billiard_shot.table.run.task import (
    BatchRecording,
    DEFAULT_MAX_EVENTS,
    DEFAULT_TOLERANCE,
    in_threads,
    joined,
    run_tables,
    run_with_events,
    TableTask,
)


@dataclass(frozen=True, eq=False)
class TableBatch(Tabular):
    """
    Runs of many tables; row by row what `simulate` gives.

    Attributes
    ----------
    names : tuple of str
        The balls; all arrays have them in this order.
    played : BatchRecording
        The rows that were recorded, of which all else are columns.
    final_position : (tables, balls, 3) float array
        Of each ball [m].
    motion : (tables, balls) uint8 array
        A `Motion`: REST, POCKETED, ABSENT ...
    pocket : (tables, balls) int array
        Index in `POCKET_NAMES`, -1: in none.
    first_met : (tables, balls) int array
        Index of the first ball that each one met, -1: none.
    duration : (tables,) float array
        Until all balls rest [s].
    status : (tables,) uint16 array
        A `Status`.
    events : (tables,) int array
        How many there were.
    searches : (tables,) int array
        How many contacts were looked for.
    double_hit : (tables,) bool array
        The cue hit ball 0 again, in the strike or later.
    jaws_met : (tables,) int array
        Rounded jaws that ball 0 met before another ball.
    rest_time : (tables, balls) float array
        Since when a ball rests, or is off the table [s].
    cushions : (tables, balls) int array
        Straight cushions that each ball met.
    last_cushion : (tables, balls) float array
        When each ball was last driven to a cushion or a jaw [s]; -inf: never. A ball is not
        driven to a nose that it already touches.
    met_time : (tables, balls) float array
        When ball 0 met each ball first [s]; inf: never.
    met_after : (tables, balls) int array
        Straight cushions that ball 0 had met by then.
    position_at : (tables, balls, times, 3) float array
        At the times that were asked for [m].

    """

    names: tuple[str, ...]
    played: BatchRecording
    final_position = column('played.balls', 'position')
    motion = column('played.balls', 'motion', np.uint8)
    pocket = column('played.balls', 'pocket')
    first_met = column('played.balls', 'first_contact')
    duration = column('played.tables', 'duration')
    status = column('played.tables', 'status', np.uint16)
    events = column('played.tables', 'events')
    searches = column('played.tables', 'searches')
    double_hit = column('played.tables', 'double_hit')
    jaws_met = column('played.tables', 'jaws_met')
    rest_time = column('played.balls', 'time')
    cushions = column('played.balls', 'cushions')
    last_cushion = column('played.balls', 'last_edge')
    met_time = column('played.balls', 'met_time')
    met_after = column('played.balls', 'met_after')
    position_at = column('played.places')

    @property
    def miscue(self) -> NDArray[np.bool_]:
        """Whether the tip slid on ball 0 in a strike (tables,)."""
        cues = self.played.cues
        return cues['miscue'] if len(cues) else np.zeros(len(self.status), np.bool_)

    @property
    def states(self) -> TableStates:
        """The balls as they rest on the table, without those that fell or left it."""
        on_table = self.motion < POCKETED
        return TableStates(self.names, self.final_position, present=on_table)

    @property
    def first_contact_time(self) -> NDArray[np.float64]:
        """When ball 0 met another ball (tables,) [s]; infinite if it met none."""
        first: NDArray[np.float64] = self.met_time.min(axis=1)
        return first

    @property
    def to_cushion(self) -> NDArray[np.bool_]:
        """Whether each ball (tables, balls) was driven to a cushion after the first contact."""
        after: NDArray[np.bool_] = self.last_cushion > self.first_contact_time[:, np.newaxis]
        return after

    @property
    def off_table(self) -> NDArray[np.bool_]:
        """Whether each ball (tables, balls) left the table."""
        off: NDArray[np.bool_] = self.motion == LEFT_TABLE
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

    def columns(self) -> dict[str, Any]:
        """
        Return the columns of `to_frame`, with a row for each table.

        `pocketed`, `off_table` and `to_cushion` are tuples of names, `first_contact` is a name or
        None, and `first_contact_time` is NaN without a first contact.
        """
        names = np.array([*self.names, None], object)
        places = {
            f'{name}_{x}': self.final_position[:, i, k]
            for i, name in enumerate(self.names)
            for k, x in enumerate('xy')
        }
        return {
            'status': [Status(each).name for each in self.status.tolist()],
            'duration': self.duration,
            'first_contact': names[self.first_met[:, 0]],
            'first_contact_time': self.first_contact_time,
            'pocketed': [tuple(each) for each in self.pocketed],
            'off_table': self._listed(self.off_table),
            'to_cushion': self._listed(self.to_cushion),
            'cushions': self.cushions[:, 0],
            'double_hit': self.double_hit,
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


def run_one(task: TableTask, names: tuple[str, ...]) -> TableRun:
    """Simulate one table, whose balls have these names, with all that happens."""
    begin = perf_counter()
    played = run_with_events(task)
    return run_of(played, names, perf_counter() - begin)


def run_of(played: BatchRecording, names: tuple[str, ...], wall_time: float) -> TableRun:
    """Return the recording of one table, whose balls have these names, as people use it."""
    end, balls = played.tables[0], played.balls[0]
    return TableRun(
        names,
        Status(int(end['run_status'])),
        float(end['duration']),
        wall_time,
        int(end['searches']),
        played.segments,
        _events=played.events,
        _places=np.stack([balls['pocket'], balls['first_contact']], axis=1),
        jaws_met=int(end['jaws_met']),
    )


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

    def simulate_rows(scene: Scene, rows: TableStates) -> TableBatch:
        starts = rows.starts()
        for field in VECTORS:
            starts[field][np.abs(starts[field]) > LARGEST] = np.nan  # compiled code refuses it
        for t, i, _ in in_cushions(scene, starts):
            starts['position'][t, i] = np.nan
        both = params_on_table(scene)
        task = TableTask(*both, starts, tolerance, tolerance, max_events, until=end, times=times)
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
    return TableBatch(tables.names, joined([part.played for part in parts], order))


def _times(at: ArrayLike | None) -> tuple[float, ...]:
    """Read times that must be ascending [s]."""
    times = np.zeros(0) if at is None else as_floats(at)
    wrong = times.ndim != 1 or not np.isfinite(times).all() or (times < 0.0).any()
    if wrong or (at is not None and not len(times)) or (np.diff(times) < 0.0).any():
        raise ValueError(f'at must be ascending times, at least 0, got {at!r} (s)')
    return tuple(times.tolist())


def run_many(task: TableTask, names: tuple[str, ...], workers: int | None = None) -> TableBatch:
    """Simulate tables, whose balls have these names, on all cores."""

    def simulate_part(part: slice) -> BatchRecording:
        return run_tables(task._replace(starts=task.starts[part]))

    return TableBatch(names, joined(in_threads(simulate_part, len(task.starts), workers)))
