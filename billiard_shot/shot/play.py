"""
Strokes from the cue to rest, one or many: strike, table, and how each of them ended.

This is the one place that decides the status of a stroke: alone, in a batch, on a table of its
own, or at a ball to which others are near. A stroke whose ball meets rounded jaws of pockets is
played again, finer: each jaw magnifies an error a few hundred times.
"""

from collections.abc import Callable
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.accuracy import Accuracy, USUAL_ACCURACY
from billiard_shot.shot.discontinuity import discontinuities_of_law
from billiard_shot.shot.mapped_strike import ALL_SOLVED, Mapped
from billiard_shot.shot.on_table import task_of
from billiard_shot.shot.setting import Setting, setting_of
from billiard_shot.shot.stroke_batch import stroke_batch, StrokeBatch
from billiard_shot.status import INFINITE_SEQUENCE, OK, TOLERANCE_NOT_REACHED
from billiard_shot.table.motion import NOTHING
from billiard_shot.table.table_states import TableStates
from billiard_shot.table.task import BatchRecording, COLUMNS, joined, run_tables, TableTask
from billiard_shot.table.threads import in_threads

CUSHION_SHARE = 0.5  # of the tolerance is set aside for cushions, which magnify errors
# Share of the tolerance for a stroke that is played again: what it errs by is far below its share,
# so it may be magnified more than a hundred times. And the error that is left, at most: a share of
# what the repetition changed.
FINER, LEFT = 1e-2, 0.05


def play(
    scene: Scene,
    normals: Array,
    velocities: Array,
    tables: TableStates | None = None,
    accuracy: Accuracy = USUAL_ACCURACY,
    mapped: Mapped = ALL_SOLVED,
    workers: int | None = None,
) -> StrokeBatch:
    """
    Play n strokes, at one table or at n tables, on all cores.

    Parameters
    ----------
    scene : Scene
    normals, velocities : (n, 3) float arrays
        As of `Stroke`; NaN where there is no stroke.
    tables : TableStates, optional
        n tables, or one for all strokes, the cue ball first; by default the balls of the scene.
    accuracy : Accuracy
    mapped : Mapped
        Which strikes come from maps; by default all are solved.
    workers : int, optional
        Threads; by default as many as there are cores.

    Raises
    ------
    ValueError
        If the first ball of the tables is not the cue ball.

    """
    if tables is not None and tables.names[0] != CUE_BALL:
        raise ValueError(f'tables must have {CUE_BALL!r} first, got {", ".join(tables.names)}')
    count, setting = len(normals), setting_of(scene)

    def play_part(rows: slice) -> BatchRecording:
        some, maps = _some(tables, rows), mapped.part(rows)
        return play_by(
            run_tables, setting, normals[rows], velocities[rows], some, accuracy, mapped=maps
        )

    parts = in_threads(play_part, count, workers) or [play_part(slice(0, 0))]
    names = setting.names if tables is None else tables.names
    return stroke_batch(scene, names, joined(parts))


def play_by(
    run: Callable[[TableTask], BatchRecording],
    setting: Setting,
    normals: Array,
    velocities: Array,
    tables: TableStates | None,
    accuracy: Accuracy,
    *,
    mapped: Mapped = ALL_SOLVED,
    rules: NDArray[np.void] | None = None,
) -> BatchRecording:
    """
    Play strokes in this thread.

    Parameters
    ----------
    run : callable
        How much is recorded: `run_tables`, `run_recorded` or, of the last stroke,
        `run_with_events`.
    setting : Setting
    normals, velocities, tables, accuracy, mapped
        As of `play`.
    rules : (balls,) array of BallRule, optional
        As of `TableTask`.

    """

    def once(rows: slice | NDArray[np.integer], accuracy: Accuracy) -> BatchRecording:
        some, n, v = _some(tables, rows), normals[rows], velocities[rows]
        task = task_of(setting, n, v, some, accuracy, mapped=mapped.part(rows), rules=rules)
        return _with_errors(run(task), setting, n, v, accuracy)

    played = once(slice(None), accuracy)
    again = np.flatnonzero(played.tables['jaws_met'])
    if accuracy.checked and len(again):
        finer = accuracy._replace(tolerance=FINER * accuracy.tolerance)
        played = _played_again(played, again, once(again, finer))
    return _with_status(played, accuracy.tolerance)


def _with_errors(
    played: BatchRecording, setting: Setting, normals: Array, velocities: Array, accuracy: Accuracy
) -> BatchRecording:
    """Note how strikes ended, and estimate the errors of strokes if they are checked."""
    cues, ball, tolerance = played.cues, played.balls[:, 0], accuracy.tolerance
    status = cues['status'].copy()
    if not accuracy.checked:
        return played._replace(status=status)
    error = cues['drift'] * ball['time']
    if math.isinf(setting.table.length):
        error += ball['left_out']
    else:
        error += np.where(error > 0.0, CUSHION_SHARE * tolerance, 0.0)
    jumps = discontinuities_of_law(setting.model, normals, velocities, cues, tolerance)
    return played._replace(status=status, error=error, discontinuity=jumps)


def _some(tables: TableStates | None, rows: slice | NDArray[np.integer]) -> TableStates | None:
    """Select the tables of some strokes."""
    return tables if tables is None or len(tables) == 1 else tables.take(rows)


def _played_again(
    played: BatchRecording, again: NDArray[np.integer], finer: BatchRecording
) -> BatchRecording:
    """Replace some of the strokes by finer ones; what these change tells the error."""
    one, other = finer.balls[:, 0], played.balls[again, 0]
    change = np.sqrt(((one['position'] - other['position']) ** 2).sum(axis=1))
    met_none = one['first_contact'] == NOTHING
    finer.error[:] = np.maximum(played.error[again], np.where(met_none, LEFT * change, 0.0))
    finest = finer.status == TOLERANCE_NOT_REACHED  # as fine as the impact can be solved
    finer.status[finest] = played.status[again][finest]
    if len(again) == len(played.status):
        return finer
    for name in COLUMNS:
        getattr(played, name)[again] = getattr(finer, name)
    return played


def _with_status(played: BatchRecording, tolerance: float) -> BatchRecording:
    """Decide how strokes ended: as the strike; if it went well, as the table and its accuracy."""
    status, table = played.status, played.tables['status']
    doubtful = (played.discontinuity > 0.0) | (played.error > tolerance)
    if not (doubtful.any() or (table != OK).any()):
        return played
    went_well = (status == OK) | (status == INFINITE_SEQUENCE)
    status = np.where(went_well & doubtful, TOLERANCE_NOT_REACHED, status)
    status = np.where(went_well & (table != OK), table, status)
    return played._replace(status=status, error=played.error + played.discontinuity)
