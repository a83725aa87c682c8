"""Strikes of the library as impacts of moving bodies, whatever takes part."""

import numpy as np

from billiard_shot.shot.effects import cue_params
from billiard_shot.table.run.layout import ENDLESS
from billiard_shot.table.run.states import ball_starts
from billiard_shot.table.run.task import run_tables, TableTask
from billiard_shot.table.strike.placement import nothing_around, Strokes


def strike(model, places, axes, normals, speeds, table=ENDLESS, **changes):
    """
    Strike the first ball of places (balls, 3) with n cues; return the recording of the tables.

    Parameters are unit vectors (n, 3) of cues and where they touch, and speeds (n,). A ball that
    comes back to the cloth in the strike does not leave it again. `changes` are of `CueParams`.
    """
    strokes = Strokes(normals, axes * speeds[:, np.newaxis], nothing_around(0.0, 1.0))
    starts = ball_starts(1, len(places))
    starts['position'] = places
    params = cue_params(model, table)._replace(**changes)
    surface = model.surface._replace(cloth_restitution=-1.0)  # a bounce has no impulse
    return run_tables(
        TableTask(surface, table, starts, 1.0, cue=params, strokes=strokes, until=0.0)
    )
