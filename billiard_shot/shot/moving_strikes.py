"""
Strikes that are impacts of moving bodies, at a ball near others or one that the tip meets again.

The tip presses the ball for about a millisecond. Meanwhile the ball may reach other balls or a
cushion, or meet the tip or the cloth more than once. Then the strike is the impact with which a
run of the table begins (table/gather.py), with the distances and normals of each moment.

Under other laws than `bistiffness` bodies stay in place: only this law defines how contacts close
again. All contacts then take part that touch at first, and the tip meets the ball once.
"""

from math import hypot, inf

import numpy as np

from billiard_shot.records import Array
from billiard_shot.shot.accuracy import strike_tolerance
from billiard_shot.shot.strike import IMPACT_TOLERANCE, PHASE_ROOM, Strikes, Strokes
from billiard_shot.status import MISS
from billiard_shot.table.cue import TIP_DURATION
from billiard_shot.table.flight import bounce
from billiard_shot.table.motion import BallRecord, start_ball
from billiard_shot.table.params import BallClothParams, GATE_OFF, TableParams
from billiard_shot.table.simulate import run_tables, run_with_events, TableTask

FARTHEST = 2.0  # way of a ball while a tip touches it, in lengths that the cue alone would go


def with_moving_bodies(
    strokes: Strokes, tolerance: float, table: TableParams, done: Strikes, recorded: bool
) -> Strikes:
    """
    Solve the strikes anew in which tip and cloth are not alone, or meet the ball again.

    Parameters
    ----------
    strokes : Strokes
    tolerance : float
        Of the trajectories [m].
    table : TableParams
    done : Strikes
        Of these strokes, with nothing but the cloth near the ball; changed.
    recorded : bool
        Whether the last strike is recorded in detail.

    """
    model, params, cues = strokes.model, done.params, done.cues
    nearest = nearest_distance(model.surface.radius, table, done.starts['position'])
    if nearest > params.neighbour_reach and cues['hits'].max(initial=0) < 2:
        return done
    repeated, played = cues['hits'] > 1, cues['status'] < MISS
    cues['hits'][repeated] = 1
    speeds = np.linalg.norm(strokes.velocities, axis=1)
    reach = np.minimum(FARTHEST * TIP_DURATION * speeds, params.neighbour_reach)
    near = played & (nearest <= reach)
    which = np.flatnonzero(repeated | near)
    if not len(which):
        return done
    again, starts = cues[which], done.starts[which]
    again['speed'], again['strikes'] = speeds[which], True
    accuracy = [strike_tolerance(model, speed, tolerance) for speed in again['speed'].tolist()]
    again['tolerance'] = np.where(
        near[which], IMPACT_TOLERANCE, np.minimum(accuracy, IMPACT_TOLERANCE)
    )
    starts['velocity'] = starts['spin'] = 0.0
    task = TableTask(model.surface, table, starts, tolerance, cue=params, cues=again, until=0.0)
    run = run_with_events(task, PHASE_ROOM) if recorded else run_tables(task)
    kept = (run.cues['hits'] > 0) & (repeated[which] | run.cues['others'])
    which = which[kept]
    cues[which] = run.cues[kept]
    for i in which[~cues['others'][which]] if model.table else ():
        _leave_cloth(model.surface, cues[i])
    cues['tolerance'][which], cues['strikes'][which] = IMPACT_TOLERANCE, False
    for name in ('position', 'velocity', 'spin', 'first_contact'):
        done.starts[name][which] = run.balls[name][kept]
    for name in ('velocity', 'spin'):
        done.starts[name][which, 0] = cues[name][which]
    if recorded and kept[-1] and which[-1] == len(cues) - 1:
        assert run.impact is not None
        return done._replace(log=run.impact.log, losses=run.impact.losses, events=run.events)
    return done


def _leave_cloth(params: BallClothParams, cue: np.void) -> None:
    """Let a ball that came back to the cloth in its strike leave it again."""
    if cue['velocity'][2] < 0.0:
        ball, place = BallRecord(), [0.0, 0.0, params.radius]
        start_ball(ball, place, cue['velocity'].tolist(), cue['spin'].tolist())
        bounce(params, ball)
        cue['velocity'], cue['spin'] = ball.velocity, ball.spin


def nearest_distance(radius: float, table: TableParams, places: Array) -> float:
    """
    Find the distance [m] of the first ball from others, and from the rectangle of the noses.

    Parameters
    ----------
    radius : float
        Of the balls [m].
    table : TableParams
    places : (tables, balls, 3) float array
        Centres of the balls [m], the same on all tables.

    """
    if not len(places):
        return inf
    first, others = places[0, 0], places[0, 1:]
    nearest = inf
    if len(others) and table.pair_gate != GATE_OFF:
        nearest = float(np.linalg.norm(others - first, axis=1).min()) - 2.0 * radius
    x, y, z = first.tolist()
    away = min(0.5 * table.length - abs(x), 0.5 * table.width - abs(y))
    return min(nearest, hypot(away, z - table.nose_height) - radius) if away < inf else nearest
