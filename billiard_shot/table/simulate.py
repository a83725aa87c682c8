"""`simulate`: the table alone, from the balls' states to rest; `simulate_batch`: many of those."""

from collections.abc import Mapping
from dataclasses import fields
import math
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.parameters import rows_of_parameters
from billiard_shot.scene.values import as_floats, LARGEST, positive, whole
from billiard_shot.status import Status
from billiard_shot.table.effects import params_on_table
from billiard_shot.table.initial_states import (
    in_cushions,
    States,
    validated_starts,
    VECTORS,
)
from billiard_shot.table.run import TableRun
from billiard_shot.table.table_batch import batch_of, TableBatch
from billiard_shot.table.table_states import ManyStates, table_states, TableStates
from billiard_shot.table.task import (
    BatchRecording,
    DEFAULT_MAX_EVENTS,
    DEFAULT_TOLERANCE,
    joined,
    run_tables,
    run_with_events,
    TableTask,
)
from billiard_shot.table.threads import in_threads


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
    end, balls = played.tables, played.balls[0]
    places = np.empty((len(balls), 2), np.int64)
    places[:, 0], places[:, 1] = balls['pocket'], balls['first_contact']
    return TableRun(
        names,
        Status(int(end['run_status'][0])),
        float(end['duration'][0]),
        wall_time,
        int(end['searches'][0]),
        played.segments,
        _events=played.events,
        _places=places,
        jaws_met=int(end['jaws_met'][0]),
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


def run_many(task: TableTask, names: tuple[str, ...], workers: int | None = None) -> TableBatch:
    """Simulate tables, whose balls have these names, on all cores."""

    def simulate_part(part: slice) -> BatchRecording:
        return run_tables(task.part(part))

    parts = in_threads(simulate_part, len(task.starts), workers)
    parts = parts or [simulate_part(slice(0, 0))]
    return batch_of(joined(parts), names)
