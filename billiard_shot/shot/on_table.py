"""Strokes on the table: where all balls and the cues are as their runs begin."""

import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import no_place
from billiard_shot.shot.accuracy import Accuracy, HOPS, HOPS_BEFORE_CUSHIONS
from billiard_shot.shot.cues import cues_of
from billiard_shot.shot.mapped_strike import ALL_SOLVED, Mapped
from billiard_shot.shot.setting import alone, Setting
from billiard_shot.shot.strike_model import StrikeModel
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
    model, tolerance = setting.model, accuracy.tolerance
    given = None if tables is None else tables.starts()
    cues = cues_of(setting, normals, velocities, given, mapped, tolerance)
    starts = setting.starts if given is None else given
    if len(starts) == 1:
        starts = starts.repeat(len(normals), axis=0)
    if len(mapped.middles):
        known = (cues['hits'] > 0) & ~cues['strikes']
        for name in ('velocity', 'spin'):
            starts[name][known, 0] = cues[name][known]
        if not model.on_cloth:  # a ball that would go down is put onto the cloth
            height = starts['velocity'][:, 0, 2]
            np.maximum(height, 0.0, out=height)
    to_cushions = accuracy.checked and not math.isinf(setting.table.length)
    return TableTask(
        model.surface,
        setting.table,
        starts,
        (HOPS_BEFORE_CUSHIONS if to_cushions else HOPS) * tolerance,
        cue=setting.cue,
        cues=cues,
        rules=rules,
        fast_rebounds=accuracy.fast_rebounds,
    )


def strike(
    model: StrikeModel, normals: Array, velocities: Array, tolerance: float
) -> NDArray[np.void]:
    """Solve only strikes, at a cue ball alone on endless cloth; return (n,) CueRecord."""
    task = task_of(alone(model), normals, velocities, None, Accuracy(tolerance, checked=False))
    return run_tables(task._replace(until=0.0)).cues
