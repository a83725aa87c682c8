"""Many strokes, one after the other, each at a ball in the same place among the same others."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.kernel import solve_collisions
from billiard_shot.impact.solve import solve_stored
from billiard_shot.impact.state import PhaseLog
from billiard_shot.records import as_rows, ROWS, Storage
from billiard_shot.shot.model import contact_properties
from billiard_shot.shot.moving_strikes import with_moving_bodies
from billiard_shot.shot.strike import (
    finish_strikes,
    PHASE_ROOM,
    prepare_strikes,
    Strike,
    Strikes,
    StrikeWork,
    Strokes,
    work_for,
)
from billiard_shot.table.initial_states import ball_starts
from billiard_shot.table.model import ENDLESS
from billiard_shot.table.params import TableParams
from billiard_shot.table.run import EventLog
from billiard_shot.table.simulation_state import EventRecord

STROKES_AT_ONCE = 500  # strokes: their arrays stay in the processor's cache
NO_BALLS = np.zeros((0, 3))
NO_EVENTS = EventLog(ROWS.records(EventRecord, 0), np.zeros((0, 2), np.int64))


def strike_batch(
    strokes: Strokes,
    tolerance: float,
    table: TableParams = ENDLESS,
    others: NDArray[np.float64] = NO_BALLS,
    recorded: bool = False,
) -> Strikes:
    """
    Strike the ball with each stroke, by default with nothing but the cloth near it.

    A refused stroke leaves the ball where it is. A row of normals or velocities that is none (not
    finite, or zero) gets the status INVALID_STROKE.

    Parameters
    ----------
    strokes : Strokes
    tolerance : float
        Of the trajectories [m].
    table : TableParams
    others : (balls, 3) float array
        Centres of the other balls [m].
    recorded : bool
        Whether the last strike is recorded in detail, of up to 500 strokes.

    """
    storage = solve_collisions.current().storage
    parts = [
        slice(i, i + STROKES_AT_ONCE) for i in range(0, len(strokes.normals), STROKES_AT_ONCE)
    ]
    rows, log = [ROWS.records(Strike, 0)], ROWS.records(PhaseLog, 0).reshape(-1, 2)
    for part in parts:
        each, log = _strike(storage, strokes.some(part), tolerance, PHASE_ROOM if recorded else 0)
        rows.append(each)
    strikes = rows[-1] if len(parts) == 1 else np.concatenate(rows)
    starts = starts_of(strokes.position, others, len(strikes))
    starts['velocity'][:, 0], starts['spin'][:, 0] = strikes['velocity'], strikes['spin']
    done = Strikes(strikes, starts, log, np.zeros((0, 2)), NO_EVENTS)
    return with_moving_bodies(strokes, tolerance, table, done, recorded)


def starts_of(
    place: NDArray[np.float64], others: NDArray[np.float64], tables: int
) -> NDArray[np.void]:
    """Make (tables, balls) BallStart: the struck ball at a place (3,), and others (balls, 3)."""
    starts = ball_starts(tables, 1 + len(others))
    starts['position'][:, 0], starts['position'][:, 1:] = place, others
    return starts


def _strike(
    storage: Storage, strokes: Strokes, tolerance: float, phases: int
) -> tuple[NDArray[np.void], NDArray[np.void]]:
    stored, work = _prepared(storage, strokes, tolerance)
    results, outcomes, log = solve_stored(
        storage,
        contact_properties(strokes.model),
        work.delassus,
        work.approach,
        work.accuracy,
        phases,
    )
    finish_strikes.on(storage)(stored, work, results, outcomes)
    return as_rows(Strike, work.strikes), log


def refusals(strokes: Strokes) -> NDArray[np.int64]:
    """Find the status (n,) with which each stroke would be refused, or OK; see `strike_batch`."""
    storage = prepare_strikes.current().storage
    _, work = _prepared(storage, strokes, 1.0)
    status: NDArray[np.int64] = as_rows(Strike, work.strikes)['status']
    return status


def _prepared(storage: Storage, strokes: Strokes, tolerance: float) -> tuple[Strokes, StrikeWork]:
    """Put strokes into a storage, and prepare their strikes."""
    stored, work = strokes.stored(storage), work_for(storage, len(strokes.normals))
    prepare_strikes.on(storage)(stored, work, tolerance)
    return stored, work
