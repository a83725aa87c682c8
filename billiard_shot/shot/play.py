"""Strokes from the cue to rest, one or many; the entry `play_tables` does it."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.accuracy import Accuracy, USUAL_ACCURACY
from billiard_shot.shot.discontinuity import with_discontinuities
from billiard_shot.shot.on_table import task_of
from billiard_shot.shot.setting import Setting, setting_of
from billiard_shot.shot.stroke_batch import stroke_batch, StrokeBatch
from billiard_shot.table.mapped_strike import ALL_SOLVED, Mapped
from billiard_shot.table.table_states import TableStates
from billiard_shot.table.task import BatchRecording, joined, run_tables, TableTask
from billiard_shot.table.threads import in_threads


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
        some, maps = tables, mapped.part(rows)
        if tables is not None and len(tables) > 1:
            some = tables.take(rows)
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
    task = task_of(setting, normals, velocities, tables, accuracy, mapped, rules)
    played = run(task)
    if not accuracy.checked:
        return played
    return with_discontinuities(played, setting.model, normals, velocities, accuracy.tolerance)
