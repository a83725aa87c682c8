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
from numpy.typing import NDArray

from billiard_shot.records import Array, ROWS
from billiard_shot.shot.accuracy import strike_tolerance
from billiard_shot.shot.model import cue_params, tip_reach
from billiard_shot.shot.strike import MISCUE_SLIP, PHASE_ROOM, strike_status, Strikes, Strokes
from billiard_shot.status import MISS
from billiard_shot.table.cue import CueRecord, TIP_DURATION
from billiard_shot.table.flight import bounce
from billiard_shot.table.motion import BallRecord, start_ball
from billiard_shot.table.params import BallClothParams, GATE_OFF, TableParams
from billiard_shot.table.simulate import BatchRecording, run_tables, run_with_events, TableTask

IMPACT_TOLERANCE = 1e-9  # of an impact with the cue, relative to its largest approach speed
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
    model, rows = strokes.model, done.rows
    cue = cue_params(model, table)
    nearest = nearest_distance(model.surface.radius, table, done.starts['position'])
    repeated = (rows['hits'] > 1) & (model.follows and cue.moves)
    rows['hits'] = np.minimum(rows['hits'], 1)
    if nearest > cue.neighbour_reach and not repeated.any():
        return done
    played = rows['status'] < MISS
    repeated &= played
    speeds = np.linalg.norm(strokes.velocities, axis=1)
    reach = np.minimum(FARTHEST * TIP_DURATION * speeds, cue.neighbour_reach)
    near = played & (nearest <= reach)
    which = np.flatnonzero(repeated | near)
    if not len(which):
        return done
    cues: NDArray[np.void] = ROWS.records(CueRecord, len(which))
    cues['tip'] = strokes.position + tip_reach(model) * rows['axes'][which, :3]
    cues['axis'] = strokes.velocities[which] / speeds[which, np.newaxis]
    cues['speed'], cues['strikes'] = speeds[which], True
    accuracy = [strike_tolerance(model, speed, tolerance) for speed in cues['speed'].tolist()]
    cues['tolerance'] = np.where(
        near[which], IMPACT_TOLERANCE, np.minimum(accuracy, IMPACT_TOLERANCE)
    )
    starts = done.starts[which]
    starts['velocity'] = starts['spin'] = 0.0
    task = TableTask(model.surface, table, starts, tolerance, cue=cue, cues=cues, until=0.0)
    run = run_with_events(task, PHASE_ROOM) if recorded else run_tables(task)
    others = run.cues['others']
    down = ~others & (run.balls['velocity'][:, 0, 2] < 0.0) & model.table
    for i in np.flatnonzero(down):
        _bounce(model.surface, run.balls[i, 0])
    kept = (run.cues['hits'] > 0) & (repeated[which] | others)
    _write(done, which[kept], run.cues[kept], run.balls[kept], speeds)
    if recorded and kept[-1] and which[-1] == len(rows) - 1:
        return _with_details(done, run)
    return done


def _write(
    done: Strikes, which: NDArray[np.int64], cues: NDArray[np.void], balls: NDArray[np.void],
    speeds: Array,
) -> None:  # fmt: skip
    """Write what strikes did: `cues` and `balls`, as they leave them; `speeds`: of the strokes."""
    rows, starts = done.rows, done.starts
    frames = rows['axes'][which].reshape(-1, 2, 3, 3)
    along = frames @ cues['impulses'].reshape(-1, 2, 3, 1)
    rows['impulses'][which], rows['losses'][which] = along.reshape(-1, 6), cues['losses']
    rows['velocity'][which], rows['spin'][which] = balls['velocity'][:, 0], balls['spin'][:, 0]
    rows['cue_speed'][which] = cues['speed']
    rows['tip'][which] = cues['tip'] - balls['position'][:, 0]
    for name in ('hits', 'phases', 'steps'):
        rows[name][which] = cues[name]
    rows['moving'][which], rows['together'][which] = True, cues['others']
    slips = cues['first_slip'] > MISCUE_SLIP * speeds[which]
    rows['status'][which] = [
        strike_status(status, slip)
        for status, slip in zip(cues['status'].tolist(), slips.tolist(), strict=True)
    ]
    for name in ('velocity', 'spin', 'first_contact'):
        starts[name][which] = balls[name]
    reached = cues['others']  # a ball alone begins where it was struck
    starts['position'][which[reached]] = balls['position'][reached]


def _bounce(params: BallClothParams, outcome: np.void) -> None:
    """Let a ball that came back to the cloth in its strike leave it again."""
    ball, place = BallRecord(), [0.0, 0.0, params.radius]
    start_ball(ball, place, outcome['velocity'].tolist(), outcome['spin'].tolist())
    bounce(params, ball)
    outcome['velocity'], outcome['spin'] = ball.velocity, ball.spin


def _with_details(done: Strikes, run: BatchRecording) -> Strikes:
    """Add the details of the last strike."""
    assert run.impact is not None
    return done._replace(log=run.impact.log, losses=run.impact.losses, events=run.events)


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
