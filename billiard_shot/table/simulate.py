"""`simulate`: the table alone, from the balls' states to rest; `simulate_batch`: many of those."""
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
import math
import os
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.status import Status
from billiard_shot.table import motion, world
from billiard_shot.table.cluster import resolve
from billiard_shot.table.effects import numbers_on_table
from billiard_shot.table.furniture import Furniture
from billiard_shot.table.play import INPUT, play_tables, RESULT
from billiard_shot.table.run import TableRun
from billiard_shot.table.surface import Surface
from billiard_shot.table.trajectory import BallState

# Hops after impacts with balls and cushions that move a ball by less [m] are left out. Friction
# between balls makes one at nearly every impact, a third of a millimetre high at most.
DEFAULT_TOLERANCE = 2e-3
DEFAULT_LIMIT = 20_000  # events of a table
_SEGMENTS, _EVENTS = 256, 256  # rows that most runs have room in

States = Mapping[str, BallState]


def simulate(
    scene: Scene,
    states: States,
    tolerance: float = DEFAULT_TOLERANCE,
    max_events: int = DEFAULT_LIMIT,
) -> TableRun:
    """
    Simulate all that balls do on a table, without a stroke, until they rest.

    Parameters
    ----------
    scene : Scene
        Its `table`; without one the cloth is endless. `balls` does not count here.
    states : mapping of str to BallState
        The balls by name: position (3,) [m], velocity (3,) [m/s], spin (3,) [rad/s].
    tolerance : float
        Hops of a ball that move it by less are left out [m], above 0.
    max_events : int
        A run that takes more ends with BUDGET_EXCEEDED.

    Returns
    -------
    TableRun
        `status`: OK, OFF_TABLE (a ball left it), NEVER_RESTS or BUDGET_EXCEEDED.

    Raises
    ------
    ValueError
        Naming the ball, field and value that makes no sense.

    """
    check_options(tolerance, max_events)
    return run_one(scene, tuple(states), _checked(scene, states), tolerance, tolerance, max_events)


def run_one(
    scene: Scene, names: tuple[str, ...], given: NDArray[np.float64], tolerance: float,
    hop: float = DEFAULT_TOLERANCE, max_events: int = DEFAULT_LIMIT,
) -> TableRun:
    """Simulate one table from checked states (1, balls, INPUT), with all that happens."""
    begin = perf_counter()
    surface, furniture = numbers_on_table(scene)
    room = _SEGMENTS, _EVENTS
    while True:
        segments = np.empty((room[0], motion.COLUMNS + 1))
        events = np.empty((room[1], world.EVENT_COLUMNS))
        _, summary, places = _play(
            surface, furniture, given, tolerance, hop, max_events, segments, events
        )
        needed = int(summary[0, 2]), int(summary[0, 3])
        if needed[0] <= room[0] and needed[1] <= room[1]:
            break
        room = needed
    return TableRun(
        names, Status(int(summary[0, 1])), float(summary[0, 0]), perf_counter() - begin,
        int(summary[0, 4]), segments[: needed[0]], events[: needed[1]], places[0],
    )


def _play(
    surface: Surface, furniture: Furniture, given: NDArray[np.float64], tolerance: float,
    hop: float, max_events: int, segments: NDArray[np.float64], events: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    """Play tables: see `play_tables` for what comes back."""
    tables, count = given.shape[:2]
    results, summary = np.empty((tables, count, RESULT)), np.empty((tables, 5))
    places = np.empty((tables, count, 2), np.int64)
    w = world.empty_world(count, segments, events)
    table = 0
    while True:
        table = play_tables(
            surface, furniture, given, table, tolerance, hop, max_events, w, results, summary,
            places,
        )
        if table == tables:
            return results, summary, places
        resolve(surface, furniture, w)


@dataclass(frozen=True, slots=True, eq=False)
class TableBatch:
    """Runs of many tables; row by row what `simulate` gives. Balls in the order of `names`."""

    names: tuple[str, ...]
    rest: NDArray[np.float64]  # (tables, balls, 3) m: where each ball ends
    motion: NDArray[np.uint8]  # (tables, balls) a Motion: REST, POCKETED, OFF_TABLE ...
    pocket: NDArray[np.int64]  # (tables, balls) index in POCKET_NAMES, -1: in none
    first_met: NDArray[np.int64]  # (tables, balls) index of the first ball each met, -1: none
    duration: NDArray[np.float64]  # (tables,) s until all rest
    status: NDArray[np.uint16]  # (tables,) Status
    events: NDArray[np.int64]  # (tables,) how many there were
    searches: NDArray[np.int64]  # (tables,) how many contacts were looked for


def simulate_batch(
    scene: Scene,
    states: States | Sequence[States],
    tolerance: float = DEFAULT_TOLERANCE,
    max_events: int = DEFAULT_LIMIT,
    workers: int | None = None,
) -> TableBatch:
    """
    Simulate many tables at once, on all cores.

    Parameters
    ----------
    scene, tolerance, max_events
        As for `simulate`.
    states : mapping of str to BallState, or sequence of such mappings
        One mapping whose arrays are (tables, 3), or (3,) for all tables alike; or a mapping for
        each table, all with the same balls. A row that cannot be (not finite, overlapping balls)
        gets the status INVALID_REQUEST.
    workers : int, optional
        Threads; by default as many as there are cores.

    """
    check_options(tolerance, max_events)
    names, given = _many(states)
    return run_many(scene, names, given, tolerance, tolerance, max_events, workers)


def run_many(
    scene: Scene, names: tuple[str, ...], given: NDArray[np.float64], tolerance: float,
    hop: float = DEFAULT_TOLERANCE, max_events: int = DEFAULT_LIMIT, workers: int | None = None,
) -> TableBatch:
    """Simulate tables from states (tables, balls, INPUT)."""
    surface, furniture = numbers_on_table(scene)
    tables = len(given)
    threads = workers or os.cpu_count() or 1
    size = max(1, math.ceil(tables / (8 * threads)))  # small parts: tables differ in cost
    nothing = np.empty((0, motion.COLUMNS + 1)), np.empty((0, world.EVENT_COLUMNS))

    def play(begin: int) -> tuple[NDArray[Any], ...]:
        part = given[begin : begin + size]
        return _play(surface, furniture, part, tolerance, hop, max_events, *nothing)

    with ThreadPoolExecutor(threads) as pool:
        parts = list(pool.map(play, range(0, tables, size)))
    empty = _play(surface, furniture, given[:0], tolerance, hop, max_events, *nothing)
    results, summary, places = (np.concatenate(part) for part in zip(empty, *parts, strict=True))
    return TableBatch(
        names=names, rest=results[..., :3], motion=results[..., 9].astype(np.uint8),
        pocket=places[..., 0], first_met=places[..., 1], duration=summary[:, 0],
        status=summary[:, 1].astype(np.uint16), events=summary[:, 3].astype(np.int64),
        searches=summary[:, 4].astype(np.int64),
    )


def check_options(tolerance: float, max_events: int) -> None:
    """Raise ValueError for options that make no sense."""
    if not 0.0 < tolerance < math.inf:
        raise ValueError(
            f'tolerance: {tolerance!r} is not allowed; it must be finite and above 0 (m)'
        )
    if isinstance(max_events, bool) or not isinstance(max_events, int) or max_events < 1:
        raise ValueError(
            f'max_events: {max_events!r} is not allowed; it must be a whole number, at least 1'
        )


def _row(name: str, state: BallState) -> list[NDArray[np.float64]]:
    rows = []
    for field in ('position', 'velocity', 'spin'):
        try:
            row = np.asarray(getattr(state, field), dtype=float)
        except (TypeError, ValueError):
            row = np.empty(0)
        if row.ndim not in (1, 2) or row.shape[-1] != 3:
            raise ValueError(
                f'states[{name!r}].{field}: {getattr(state, field)!r} is not allowed; it must be '
                'three numbers, or rows of three'
            )
        rows.append(row)
    return rows


def _checked(scene: Scene, states: States) -> NDArray[np.float64]:
    """(1, balls, INPUT) states, all of which can be."""
    radius = scene.ball.radius
    given = np.empty((1, len(states), INPUT))
    for i, (name, state) in enumerate(states.items()):
        rows = _row(name, state)
        for k, (field, row) in enumerate(zip(('position', 'velocity', 'spin'), rows, strict=True)):
            if row.shape != (3,) or not np.isfinite(row).all():
                raise ValueError(
                    f'states[{name!r}].{field}: {getattr(state, field)!r} is not allowed; it must '
                    'be three finite numbers'
                )
            given[0, i, 3 * k : 3 * k + 3] = row
        if given[0, i, 2] < radius * (1.0 - 1e-6):
            raise ValueError(
                f'states[{name!r}].position: {given[0, i, 2]:.6g} is not allowed as z; it must be '
                f'at least the radius, {radius:g} (m)'
            )
        table = scene.table
        if table is not None and (
            abs(given[0, i, 0]) > 0.5 * table.length or abs(given[0, i, 1]) > 0.5 * table.width
        ):
            raise ValueError(
                f'states[{name!r}].position: ({given[0, i, 0]:g}, {given[0, i, 1]:g}) is not '
                f'allowed; it must be on the table, within {0.5 * table.length:g} and '
                f'{0.5 * table.width:g} of its middle (m)'
            )
    names, places = list(states), given[0, :, :3]
    for i in range(len(names)):
        gaps = np.linalg.norm(places[:i] - places[i], axis=1) - 2.0 * radius
        for j in np.flatnonzero(gaps < -1e-9):
            raise ValueError(
                f'states: balls {names[j]!r} and {names[i]!r} overlap by {-gaps[j]:.3g} m'
            )
    return given


def _many(states: States | Sequence[States]) -> tuple[tuple[str, ...], NDArray[np.float64]]:
    """Names of the balls, and (tables, balls, INPUT) states."""
    if isinstance(states, Mapping):
        names = tuple(states)
        rows = [[np.atleast_2d(row) for row in _row(name, states[name])] for name in names]
        counts = {len(row) for ball in rows for row in ball} - {1}
        if len(counts) > 1:
            raise ValueError(
                f'states: arrays of {sorted(counts)} rows are not allowed; all must have as many'
            )
        tables = counts.pop() if counts else 1
        given = np.empty((tables, len(names), INPUT))
        for i, ball in enumerate(rows):
            for k, row in enumerate(ball):
                given[:, i, 3 * k : 3 * k + 3] = row
        return names, given
    names = tuple(states[0]) if len(states) else ()
    given = np.empty((len(states), len(names), INPUT))
    for t, table in enumerate(states):
        if set(table) != set(names):
            raise ValueError(
                f'states[{t}]: balls {sorted(table)} are not allowed; all tables must have the '
                f'same, {sorted(names)}'
            )
        for i, name in enumerate(names):
            given[t, i] = np.concatenate(_row(name, table[name]))
    return names, given
