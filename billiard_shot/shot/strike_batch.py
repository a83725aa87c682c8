"""Many strokes, one after the other, each with the ball in the same place, on endless cloth."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.kernel import solve_collisions
from billiard_shot.impact.solve import solve_stored
from billiard_shot.records import as_rows, ROWS, Storage
from billiard_shot.shot.clearance import NOTHING_AROUND, Surroundings
from billiard_shot.shot.model import contact_properties, StrikeModel
from billiard_shot.shot.moving_normals import with_moving_normals
from billiard_shot.shot.strike import (
    finish_strikes,
    no_phases,
    prepare_strikes,
    stored,
    Strike,
    Strikes,
    StrikeTask,
    StrikeWork,
    work_for,
)
from billiard_shot.table.motion import Segment

AT_ONCE = 500  # strokes: their arrays stay in the processor's cache


def strike_batch(
    model: StrikeModel,
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
    position: NDArray[np.float64],
    tolerance: float,
    around: Surroundings = NOTHING_AROUND,
    phases: int = 0,
    segments: int = 0,
) -> Strikes:
    """
    Play strokes, one after the other, each with the ball in the same place, on endless cloth.

    A refused stroke leaves the ball where it is.

    Parameters
    ----------
    model : StrikeModel
    normals, velocities : (n, 3) float arrays
        As of `Stroke`. A row that is none (not finite, or zero) gets the status INVALID_STROKE.
    position : (3,) float array
        Centre of the cue ball [m].
    tolerance : float
        Of the trajectories [m].
    around : Surroundings
        A cue that has no room among them is refused.
    phases, segments : int
        If above 0, all those of the last stroke are returned, of up to 500 strokes. More of them
        take longer.

    """
    storage = solve_collisions.current().storage
    parts = [slice(i, i + AT_ONCE) for i in range(0, len(normals), AT_ONCE)]
    done = [
        _strike(
            storage,
            model,
            around,
            normals[part],
            velocities[part],
            position,
            tolerance,
            phases,
            segments,
        )
        for part in parts
    ]
    if len(done) == 1:
        return done[0]
    strikes = np.concatenate([ROWS.records(Strike, 0), *(each.strikes for each in done)])
    return Strikes(strikes, no_phases(), ROWS.records(Segment, 0))


def _strike(
    storage: Storage,
    model: StrikeModel,
    around: Surroundings,
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
    position: NDArray[np.float64],
    tolerance: float,
    phases: int,
    segments: int,
) -> Strikes:
    task, work = _prepared(storage, model, around, normals, velocities, position, tolerance)
    results, outcomes, log = solve_stored(
        storage, contact_properties(model), work.delassus, work.approach, work.accuracy, phases
    )
    while True:
        motion = storage.records(Segment, segments)
        finish_strikes.on(storage)(task, work, results, outcomes, motion)
        needed = int(work.strikes[-1].segments) if segments and len(normals) else 0
        if needed <= segments:
            break
        segments = needed
    done = Strikes(as_rows(Strike, work.strikes), log, as_rows(Segment, motion)[:needed])
    return with_moving_normals(model, velocities, position, tolerance, done)


def refusals(
    model: StrikeModel,
    around: Surroundings,
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
    position: NDArray[np.float64],
) -> NDArray[np.int64]:
    """Find the status (n,) with which each stroke would be refused, or OK; see `strike_batch`."""
    storage = prepare_strikes.current().storage
    _, work = _prepared(storage, model, around, normals, velocities, position, 1.0)
    status: NDArray[np.int64] = as_rows(Strike, work.strikes)['status']
    return status


def _prepared(
    storage: Storage,
    model: StrikeModel,
    around: Surroundings,
    normals: NDArray[np.float64],
    velocities: NDArray[np.float64],
    position: NDArray[np.float64],
    tolerance: float,
) -> tuple[StrikeTask, StrikeWork]:
    """Put strokes into a storage, and prepare their strikes."""
    array = storage.array
    task = StrikeTask(model, array(normals), array(velocities), array(position), tolerance)
    work = work_for(storage, len(normals))
    prepare_strikes.on(storage)(task, work, stored(storage, around))
    return task, work
