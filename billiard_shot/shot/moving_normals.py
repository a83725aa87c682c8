"""Strikes in which the ball meets the tip or the cloth more than once: the normals move."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.collide import Phase
from billiard_shot.impact.state import PhaseLog
from billiard_shot.records import ROWS
from billiard_shot.shot.accuracy import drift_of, strike_tolerance
from billiard_shot.shot.cue_contact import meet, Meeting, TOLERANCE
from billiard_shot.shot.model import tip_reach
from billiard_shot.shot.neighbours import bodies_move
from billiard_shot.shot.strike import MISCUE_SLIP, PHASES, strike_status, Strikes, Strokes
from billiard_shot.status import MISS
from billiard_shot.table.flight import bounce
from billiard_shot.table.motion import Ball, start_ball
from billiard_shot.table.params import BallClothParams


def with_moving_normals(
    strokes: Strokes, tolerance: float, done: Strikes, recorded: bool
) -> Strikes:
    """
    Solve the strikes anew in which the ball meets the tip or the cloth more than once.

    Only law `bistiffness` knows how: under the others the directions stay as they are at first.
    """
    model, velocities, position = strokes.model, strokes.velocities, strokes.position
    strikes, log = done.rows, done.log
    again = np.flatnonzero((strikes['hits'] > 1) & (strikes['status'] < MISS))
    if not model.follows or not bodies_move(model) or not len(again):
        strikes['hits'] = np.minimum(strikes['hits'], 1)
        return done
    speeds = np.linalg.norm(velocities[again], axis=1)
    axes = velocities[again] / speeds[:, np.newaxis]
    frames = strikes['axes'][again].reshape(-1, 2, 3, 3)
    still, place = np.zeros((len(again), 1, 3)), np.tile(position, (len(again), 1, 1))
    reach = tip_reach(model)
    begin = Meeting(place, still, still, position + reach * frames[:, 0, 0], speeds)
    accuracy = np.array([strike_tolerance(model, speed, tolerance) for speed in speeds.tolist()])
    room = PHASES if recorded else 0
    met = meet(model, axes, begin, np.minimum(accuracy, TOLERANCE), phases=room)
    strikes['velocity'][again], strikes['spin'][again] = (
        met.after.velocity[:, 0],
        met.after.spin[:, 0],
    )
    strikes['cue_speed'][again], strikes['hits'][again] = met.after.speed, met.hits
    strikes['tip'][again] = met.after.tip - met.after.position[:, 0]
    strikes['impulses'][again] = (frames @ met.impulses[..., np.newaxis]).reshape(-1, 6)
    strikes['losses'][again] = met.losses.reshape(-1, 4)
    strikes['steps'][again], strikes['phases'][again] = met.steps, met.phases
    for i, row in enumerate(again):
        strike, slips = strikes[row], met.first_slip[i] > MISCUE_SLIP * speeds[i]
        strike['drift'] = drift_of(accuracy[i], speeds[i])
        strike['status'] = strike_status(int(met.status[i]), slips)
        if strike['velocity'][2] < 0.0 and model.table:
            _bounce(model.surface, strike)
        if recorded and row == len(strikes) - 1:
            log = log_of(met.log, frames[i])
    return done._replace(log=log)


def _bounce(params: BallClothParams, strike: np.void) -> None:
    """Let the ball leave the cloth, to which it came again."""
    ball = Ball()
    start_ball(
        ball, [0.0, 0.0, params.radius], strike['velocity'].tolist(), strike['spin'].tolist()
    )
    bounce(params, ball)
    strike['velocity'], strike['spin'] = ball.velocity, ball.spin


def log_of(phases: Sequence[Phase], frames: NDArray[np.float64]) -> NDArray[np.void]:
    """Write phases as a log (phases, 2); `frames`: (2, 3, 3), normal and tangents as rows."""
    log = ROWS.records(PhaseLog, 2 * len(phases)).reshape(-1, 2)
    for row, phase in zip(log, phases, strict=True):
        row['ending'], row['contact'], row['energy'] = phase.ending, phase.contact, phase.energies
        row['active'][list(phase.active)] = 1
        along = np.einsum('kij,kj->ki', frames, phase.impulses)
        row['impulse'], row['impulse_1'], row['impulse_2'] = along.T
    return log
