"""Strikes of the library as impacts of moving bodies, whatever takes part."""

from billiard_shot.records import ROWS
from billiard_shot.shot.model import cue_params, tip_reach
from billiard_shot.shot.strike_batch import starts_of
from billiard_shot.table.cue import CueRecord
from billiard_shot.table.model import ENDLESS
from billiard_shot.table.simulate import run_tables, TableTask


def strike(model, places, axes, normals, speeds, table=ENDLESS):
    """
    Strike the first ball of places (balls, 3) with n cues; return the recording of the tables.

    Parameters are unit vectors (n, 3) of cues and where they touch, and speeds (n,).
    """
    cues = ROWS.records(CueRecord, len(axes))
    cues['axis'], cues['speed'], cues['strikes'], cues['tolerance'] = axes, speeds, True, 1e-9
    cues['tip'] = places[0] + tip_reach(model) * normals
    starts = starts_of(places[0], places[1:], len(axes))
    params = cue_params(model, table)
    return run_tables(
        TableTask(model.surface, table, starts, 1.0, cue=params, cues=cues, until=0.0)
    )
