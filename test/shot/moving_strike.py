"""Strikes of the library as impacts of moving bodies, whatever takes part."""

from billiard_shot.records import ROWS
from billiard_shot.shot.strike_model import cue_params, tip_reach
from billiard_shot.table.cue import CueRecord
from billiard_shot.table.initial_states import ball_starts
from billiard_shot.table.scene_params import ENDLESS
from billiard_shot.table.task import run_tables, TableTask


def strike(model, places, axes, normals, speeds, table=ENDLESS):
    """
    Strike the first ball of places (balls, 3) with n cues; return the recording of the tables.

    Parameters are unit vectors (n, 3) of cues and where they touch, and speeds (n,). A ball that
    comes back to the cloth in the strike does not leave it again.
    """
    cues = ROWS.records(CueRecord, len(axes))
    cues['axis'], cues['speed'], cues['tolerance'] = axes, speeds, 1e-9
    cues['strikes'] = cues['others'] = True
    cues['tip'] = places[0] + tip_reach(model) * normals
    starts = ball_starts(len(axes), len(places))
    starts['position'] = places
    params = cue_params(model, table)._replace(steady=False)
    surface = model.surface._replace(cloth_restitution=-1.0)  # a bounce has no impulse
    return run_tables(TableTask(surface, table, starts, 1.0, cue=params, cues=cues, until=0.0))
