"""Many strokes, one after the other, each at a ball in the same place among the same others."""

from math import inf

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.beginning import Collisions
from billiard_shot.impact.kernel import solve_collisions
from billiard_shot.impact.solve import solve_given
from billiard_shot.records import as_rows, ROWS, Storage
from billiard_shot.shot.model import cue_params
from billiard_shot.shot.moving_strikes import with_moving_bodies
from billiard_shot.shot.strike import (
    finish_strikes,
    PHASE_ROOM,
    prepare_strikes,
    Strikes,
    StrikeWork,
    Strokes,
    work_for,
)
from billiard_shot.table.cue import CueParams, CueRecord, NO_CUE
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
    params = cue_params(strokes.model, table)
    n, phases = len(strokes.normals), PHASE_ROOM if recorded else 0
    if n <= STROKES_AT_ONCE:
        cues, log = _strike(strokes, params, tolerance, phases)
    else:
        parts = [strokes.some(slice(i, i + STROKES_AT_ONCE)) for i in range(0, n, STROKES_AT_ONCE)]
        done = [_strike(part, params, tolerance, phases) for part in parts]
        cues, log = np.concatenate([each for each, _ in done]), done[-1][1]
    starts = starts_of(strokes.position, others, len(cues))
    starts['velocity'][:, 0], starts['spin'][:, 0] = cues['velocity'], cues['spin']
    losses = cues['losses'][-1:].reshape(-1, 2)
    alone = Strikes(params, cues, starts, log, losses, NO_EVENTS)
    return with_moving_bodies(strokes, tolerance, table, alone, recorded)


def starts_of(
    place: NDArray[np.float64], others: NDArray[np.float64], tables: int
) -> NDArray[np.void]:
    """Make (tables, balls) BallStart: the struck ball at a place (3,), and others (balls, 3)."""
    starts = ball_starts(tables, 1 + len(others))
    starts['position'][:, 0], starts['position'][:, 1:] = place, others
    return starts


def _strike(
    strokes: Strokes, params: CueParams, tolerance: float, phases: int
) -> tuple[NDArray[np.void], NDArray[np.void]]:
    """Return the cues (n,) after their strikes, and the log (phases, 2) of the last one."""
    model, storage = strokes.model, solve_collisions.current().storage
    work = _prepared(storage, strokes, params, tolerance)
    unused = storage.zeros(1, 1, 1)
    collisions = Collisions(
        properties=work.contacts,
        law=model.law,
        exponent=model.exponent,
        bodies=work.bodies,
        moves=False,
        interval=inf,
        delassus=unused,
        velocity=unused[0],
        distances=False,
        lengths=unused[0],
        tolerance=work.accuracy,
    )
    results, outcomes, log = solve_given(storage, collisions, work.bodies, phases)
    repeats = model.follows and params.moves
    finish_strikes.on(storage)(
        work, model.surface.radius, model.follows, repeats, results, outcomes
    )
    return as_rows(CueRecord, work.cues), log


def refusals(strokes: Strokes) -> NDArray[np.int64]:
    """Find the status (n,) with which each stroke would be refused, or OK; see `strike_batch`."""
    work = _prepared(prepare_strikes.current().storage, strokes, NO_CUE, 1.0)
    status: NDArray[np.int64] = as_rows(CueRecord, work.cues)['status']
    return status


def _prepared(
    storage: Storage, strokes: Strokes, params: CueParams, tolerance: float
) -> StrikeWork:
    """Put strokes into a storage, and prepare their strikes."""
    work = work_for(storage, len(strokes.normals))
    prepare_strikes.on(storage)(strokes.stored(storage), params, work, tolerance)
    return work
