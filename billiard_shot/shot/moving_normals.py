"""Strikes in which the ball meets the tip or the cloth more than once: the normals move."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.collide import Phase
from billiard_shot.impact.state import PhaseLog
from billiard_shot.records import as_rows, OBJECTS, ROWS
from billiard_shot.shot.accuracy import HOPS, strike_tolerance, trajectory_error
from billiard_shot.shot.cue_contact import meet, Meeting, TOLERANCE
from billiard_shot.shot.model import StrikeModel, tip_reach
from billiard_shot.shot.neighbours import bodies_move
from billiard_shot.shot.strike import (
    final_status,
    follow_through_time,
    MISCUE_SLIP,
    Strikes,
)
from billiard_shot.status import MISS
from billiard_shot.table.flight import bounce
from billiard_shot.table.motion import Ball, FLIGHT, Segment, start_ball
from billiard_shot.table.roll_out import roll_out

USUAL_SEGMENTS = 64  # of a ball; more are rolled out once more


def with_moving_normals(
    model: StrikeModel,
    velocities: NDArray[np.float64],
    position: NDArray[np.float64],
    tolerance: float,
    done: Strikes,
) -> Strikes:
    """
    Solve the strikes anew in which the ball meets the tip or the cloth more than once.

    Only law `bistiffness` knows how: under the others the directions stay as they are at first.
    """
    strikes = done.strikes
    again = np.flatnonzero((strikes['hits'] > 1) & (strikes['status'] < MISS))
    if not model.follows or not bodies_move(model) or not len(again):
        strikes['hits'] = np.minimum(strikes['hits'], 1)
        return done
    log, motion = done.log, done.segments
    speeds = np.linalg.norm(velocities[again], axis=1)
    axes = velocities[again] / speeds[:, np.newaxis]
    frames = strikes['axes'][again].reshape(-1, 2, 3, 3)
    still, place = np.zeros((len(again), 1, 3)), np.tile(position, (len(again), 1, 1))
    reach = tip_reach(model)
    begin = Meeting(place, still, still, position + reach * frames[:, 0, 0], speeds)
    accuracy = np.array([strike_tolerance(model, speed, tolerance) for speed in speeds.tolist()])
    met = meet(model, axes, begin, np.minimum(accuracy, TOLERANCE), phases=len(done.log))
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
        last = row == len(strikes) - 1 and len(done.segments) > 0
        room = USUAL_SEGMENTS if last else 0
        rolled = _roll_out_again(model, axes[i], position, tolerance, strike, room)
        strike['error'] += trajectory_error(accuracy[i], speeds[i], strike['duration'])
        exact = strike['error'] <= tolerance
        strike['status'] = final_status(int(met.status[i]), slips, int(strike['status']), exact)
        if last:
            motion = rolled
            log = log_of(met.log, frames[i]) if len(done.log) else log
    return Strikes(strikes, log, motion)


def _roll_out_again(
    model: StrikeModel,
    axis: NDArray[np.float64],
    position: NDArray[np.float64],
    tolerance: float,
    strike: np.void,
    room: int,
) -> NDArray[np.void]:
    """Roll out the ball of a strike whose end has changed; with room, return the segments."""
    ball, cue, segments = Ball(), Ball(), OBJECTS.records(Segment, room)
    start_ball(ball, position.tolist(), strike['velocity'].tolist(), strike['spin'].tolist())
    if ball.velocity[2] < 0.0 and model.table:  # it came to the cloth again
        bounce(model.surface, ball)
        ball.bounces = 0
        strike['velocity'], strike['spin'] = ball.velocity, ball.spin
    speed = float(strike['cue_speed'])
    cue.position, cue.velocity = (position + strike['tip']).tolist(), (speed * axis).tolist()
    cue.end, cue.motion = follow_through_time(speed), FLIGHT
    reach = tip_reach(model)
    strike['status'], strike['error'], strike['again'] = roll_out(
        model.surface, ball, HOPS * tolerance, segments, cue, reach
    )
    strike['final_position'], strike['duration'] = ball.position, ball.time
    strike['segments'] = ball.segments
    if 0 < room < ball.segments:
        return _roll_out_again(model, axis, position, tolerance, strike, ball.segments)
    return as_rows(Segment, segments[: ball.segments])


def log_of(phases: Sequence[Phase], frames: NDArray[np.float64]) -> NDArray[np.void]:
    """Write phases as a log (phases, 2); `frames`: (2, 3, 3), normal and tangents as rows."""
    log = ROWS.records(PhaseLog, 2 * len(phases)).reshape(-1, 2)
    for row, phase in zip(log, phases, strict=True):
        row['ending'], row['contact'], row['energy'] = phase.ending, phase.contact, phase.energies
        row['active'][list(phase.active)] = 1
        along = np.einsum('kij,kj->ki', frames, phase.impulses)
        row['impulse'], row['impulse_1'], row['impulse_2'] = along.T
    return log
