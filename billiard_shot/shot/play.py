"""
Strokes from the cue to rest, one or many: strike, table, and how each of them ended.

This is the one place that decides the status of a stroke: alone, in a batch, or at a ball to which
others are near. A stroke whose ball meets rounded jaws of pockets is played again, finer: each jaw
magnifies an error a few hundred times.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array
from billiard_shot.shot.accuracy import HOPS
from billiard_shot.shot.discontinuity import discontinuities_of_law
from billiard_shot.shot.on_table import table_task
from billiard_shot.shot.strike import Strokes
from billiard_shot.status import INFINITE_SEQUENCE, OK, TOLERANCE_NOT_REACHED
from billiard_shot.table.motion import NOTHING
from billiard_shot.table.simulate import (
    BatchRecording,
    in_threads,
    joined,
    run_tables,
    run_with_events,
)

# Cushions magnify errors, that of a hop ten times: half of the tolerance is set aside for that.
HOPS_BEFORE_CUSHIONS, CUSHION_SHARE = 0.1 * HOPS, 0.5
# Share of the tolerance for a stroke that is played again: what it errs by is far below its share,
# so it may be magnified more than a hundred times. And the error that is left, at most: a share of
# what the repetition changed.
FINER, LEFT = 1e-2, 0.05


class Played(NamedTuple):
    """Strokes that were played to the end."""

    run: BatchRecording
    status: NDArray[np.int64]  # (n,) Status of the whole
    error: Array  # (n,) m, of the trajectory, with the discontinuity
    discontinuity: Array  # (n,) m


def play_one(strokes: Strokes, tolerance: float) -> Played:
    """
    Play a stroke, recording all that happens.

    Parameters
    ----------
    strokes : Strokes
        One or more; the last one is recorded.
    tolerance : float
        Of the trajectories [m].

    """
    return _with_status(_play_finely(strokes, tolerance, recorded=True), tolerance)


def play_many(strokes: Strokes, tolerance: float) -> Played:
    """Play strokes on all cores; parameters as of `play_one`."""

    def play_part(part: slice) -> Played:
        return _play_finely(strokes.some(part), tolerance, recorded=False)

    parts = in_threads(play_part, len(strokes.normals))
    parts = parts or [play_part(slice(0, 0))]
    played = Played(
        joined([part.run for part in parts]),
        np.concatenate([each.status for each in parts]),
        np.concatenate([each.error for each in parts]),
        np.concatenate([each.discontinuity for each in parts]),
    )
    return _with_status(played, tolerance)


def _play_finely(strokes: Strokes, tolerance: float, recorded: bool) -> Played:
    """Play strokes, and those again that met jaws."""
    played = _play(strokes, tolerance, recorded)
    again = np.flatnonzero(played.run.tables['jaws_met'])
    if not len(again):
        return played
    finer = _play(strokes.some(again), FINER * tolerance, recorded)
    one, other = finer.run.balls[:, 0], played.run.balls[again, 0]
    change = np.sqrt(((one['position'] - other['position']) ** 2).sum(axis=1))
    met_none = one['first_contact'] == NOTHING
    error = np.maximum(played.error[again], np.where(met_none, LEFT * change, 0.0))
    finest = finer.status == TOLERANCE_NOT_REACHED  # as fine as the impact can be solved
    finer.status[finest] = played.status[again][finest]
    if recorded:
        return finer._replace(error=error)
    for name in ('cues', 'balls', 'tables'):
        getattr(played.run, name)[again] = getattr(finer.run, name)
    played.status[again] = finer.status
    played.error[again], played.discontinuity[again] = error, finer.discontinuity
    return played


def _play(strokes: Strokes, tolerance: float, recorded: bool) -> Played:
    """Play strokes; their statuses are those of the strikes."""
    endless = math.isinf(strokes.table.length)
    hops = HOPS if endless else HOPS_BEFORE_CUSHIONS
    task = table_task(strokes, tolerance, hops)
    run = run_with_events(task) if recorded else run_tables(task)
    cues = run.cues
    gap = discontinuities_of_law(strokes, cues, tolerance)
    ball = run.balls[:, 0]
    error = cues['drift'] * ball['time']
    error += ball['left_out'] if endless else np.where(error > 0.0, CUSHION_SHARE * tolerance, 0.0)
    return Played(run, cues['status'].copy(), error, gap)


def _with_status(played: Played, tolerance: float) -> Played:
    """Decide how strokes ended: as the strike; if it went well, as the table and its accuracy."""
    status, table = played.status, played.run.tables['status']
    doubtful = (played.discontinuity > 0.0) | (played.error > tolerance)
    if not (doubtful.any() or (table != OK).any()):
        return played
    went_well = (status == OK) | (status == INFINITE_SEQUENCE)
    status = np.where(went_well & doubtful, TOLERANCE_NOT_REACHED, status)
    status = np.where(went_well & (table != OK), table, status)
    return played._replace(status=status, error=played.error + played.discontinuity)
