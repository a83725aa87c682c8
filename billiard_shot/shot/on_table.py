"""Strokes on the table: where all balls are as the cue strikes."""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import no_place
from billiard_shot.shot.accuracy import Accuracy
from billiard_shot.shot.setting import alone, Setting
from billiard_shot.shot.strike_model import StrikeModel
from billiard_shot.table.cue_placement import Strokes
from billiard_shot.table.mapped_strike import ALL_SOLVED, Mapped
from billiard_shot.table.table_states import TableStates
from billiard_shot.table.task import run_tables, TableTask


def check_place(scene: Scene, centre: Array) -> None:
    """Raise ValueError if the cue ball cannot be there, because another one is, or a cushion."""
    x, y = float(centre[0]), float(centre[1])
    if why := no_place(scene.table, x, y, scene.ball.radius, scene.object_balls):
        raise ValueError(f'position must be {why}, got ({x:g}, {y:g}) (m)')


def task_of(
    setting: Setting,
    normals: Array,
    velocities: Array,
    tables: TableStates | None,
    accuracy: Accuracy,
    mapped: Mapped = ALL_SOLVED,
    rules: NDArray[np.void] | None = None,
) -> TableTask:
    """
    State the tables on which n strokes are played; a refused stroke leaves the ball where it is.

    Parameters
    ----------
    setting : Setting
    normals, velocities : (n, 3) float arrays
        As of `Stroke`, but not checked yet.
    tables : TableStates, optional
        n tables, or one for all strokes, the cue ball first; by default as the setting has them.
    accuracy : Accuracy
    mapped : Mapped
        Which strikes come from maps; by default all are solved.
    rules : (balls,) array of BallRule, optional
        As of `TableTask`.

    """
    return TableTask(
        setting.model.surface,
        setting.table,
        setting.starts if tables is None else tables.starts(),
        accuracy.tolerance,
        cue=setting.cue,
        strokes=Strokes(normals, velocities, setting.around, mapped, accuracy.checked),
        rules=rules,
        fast_rebounds=accuracy.fast_rebounds,
    )


def strike(
    model: StrikeModel, normals: Array, velocities: Array, tolerance: float
) -> NDArray[np.void]:
    """Solve only strikes, at a cue ball alone on endless cloth; return (n,) CueRecord."""
    task = task_of(alone(model), normals, velocities, None, Accuracy(tolerance, checked=False))
    return run_tables(task._replace(until=0.0)).cues
