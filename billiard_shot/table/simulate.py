"""`simulate`: the table alone, from the balls' states to rest; `simulate_batch`: many of those."""
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
import math
import os
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.status import Status
from billiard_shot.table import motion, world
from billiard_shot.table.cluster import resolve
from billiard_shot.table.effects import numbers_on_table
from billiard_shot.table.furniture import Furniture
from billiard_shot.table.given import check_options, checked, many, States
from billiard_shot.table.play import play_tables, RESULT
from billiard_shot.table.run import TableRun
from billiard_shot.table.surface import Surface

# Hops after impacts with balls and cushions that move a ball by less [m] are left out. Friction
# between balls makes one at nearly every impact, a third of a millimetre high at most.
DEFAULT_TOLERANCE = 2e-3
DEFAULT_LIMIT = 20_000  # events of a table
_SEGMENTS, _EVENTS = 256, 256  # rows that most runs have room in


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
        `status`: OK, OFF_TABLE (a ball left it), NEVER_RESTS or BUDGET_EXCEEDED; or where several
        balls at once could not be solved, that of their collision: it ends there.

    Raises
    ------
    ValueError
        Naming the ball, field and value that makes no sense.

    """
    check_options(tolerance, max_events)
    return run_one(scene, tuple(states), checked(scene, states), tolerance, tolerance, max_events)


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


class Record(NamedTuple):
    """Tables that were played, with the motion of all their balls."""

    results: NDArray[np.float64]  # (tables, balls, RESULT), see `play_tables`
    summary: NDArray[np.float64]  # (tables, 5)
    places: NDArray[np.int64]  # (tables, balls, 2)
    segments: NDArray[np.float64]  # (segments, COLUMNS + 1) of all tables, one after the other


def run_recorded(
    surface: Surface, furniture: Furniture, given: NDArray[np.float64], tolerance: float,
    hop: float = DEFAULT_TOLERANCE, max_events: int = DEFAULT_LIMIT,
) -> Record:
    """Simulate tables from states (tables, balls, INPUT) in this thread, recording all motion."""
    room = 8 * given.shape[0] * (2 + given.shape[1])
    nothing = np.empty((0, world.EVENT_COLUMNS))
    while True:
        segments = np.empty((room, motion.COLUMNS + 1))
        played = _play(surface, furniture, given, tolerance, hop, max_events, segments, nothing)
        needed = int(played[1][-1, 2]) if len(given) else 0
        if needed <= room:
            return Record(*played, segments[:needed])
        room = needed


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
    names, given = many(states)
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
