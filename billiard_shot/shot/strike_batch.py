"""Many strokes, one after the other, each at a ball in the same place, with nothing near it."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.kernel import solve_collisions
from billiard_shot.impact.solve import solve_stored
from billiard_shot.records import as_rows, ROWS, Storage
from billiard_shot.shot.model import contact_properties
from billiard_shot.shot.moving_normals import with_moving_normals
from billiard_shot.shot.strike import (
    finish_strikes,
    no_phases,
    PHASES,
    prepare_strikes,
    Strike,
    Strikes,
    StrikeWork,
    Strokes,
    work_for,
)

AT_ONCE = 500  # strokes: their arrays stay in the processor's cache


def strike_batch(strokes: Strokes, tolerance: float, recorded: bool = False) -> Strikes:
    """
    Strike the ball with each stroke, as if nothing but the cloth were near it.

    A refused stroke leaves the ball where it is. A row of normals or velocities that is none (not
    finite, or zero) gets the status INVALID_STROKE.

    Parameters
    ----------
    strokes : Strokes
    tolerance : float
        Of the trajectories [m].
    recorded : bool
        Whether all phases of the last strike are returned, of up to 500 strokes.

    """
    storage = solve_collisions.current().storage
    parts = [slice(i, i + AT_ONCE) for i in range(0, len(strokes.normals), AT_ONCE)]
    done = [_strike(storage, strokes.some(part), tolerance, recorded) for part in parts]
    if len(done) == 1:
        return done[0]
    return Strikes(
        np.concatenate([ROWS.records(Strike, 0), *(each.rows for each in done)]), no_phases()
    )


def _strike(storage: Storage, strokes: Strokes, tolerance: float, recorded: bool) -> Strikes:
    stored, work = _prepared(storage, strokes, tolerance)
    results, outcomes, log = solve_stored(
        storage,
        contact_properties(strokes.model),
        work.delassus,
        work.approach,
        work.accuracy,
        PHASES if recorded else 0,
    )
    finish_strikes.on(storage)(stored, work, results, outcomes)
    done = Strikes(as_rows(Strike, work.strikes), log)
    return with_moving_normals(strokes, tolerance, done, recorded)


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
