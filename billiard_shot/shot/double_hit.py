"""
The cue that follows its stroke, and may hit the ball again: a double hit, a foul in most games.

After the strike the cue goes on along its line with the speed that the strike left it, as far as
players follow through. The ball may have met another ball close in front, or come back with draw
or from a cushion, or the table may have thrown it against the cue. What follows is simulated as
any other event; the impact is that of cue_contact.py.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import ROWS
from billiard_shot.shot.cue_contact import MAX_HITS, meet, Meeting, TOLERANCE
from billiard_shot.shot.model import StrikeModel, TABLE, tip_reach
from billiard_shot.shot.neighbours import FIXED, neighbours_of
from billiard_shot.shot.strike import follow_through_time
from billiard_shot.status import Status
from billiard_shot.table.cluster import leave_impact
from billiard_shot.table.cushion import advance_free
from billiard_shot.table.geometry import Table
from billiard_shot.table.motion import advance, Ball, CUE, FLIGHT, IMPACT, NOTHING
from billiard_shot.table.simulate import Cues
from billiard_shot.table.simulation_state import (
    energy_of,
    FollowingCue,
    kinetic_energy,
    log_event,
    position_at,
    Simulation,
)


def following_cues(
    model: StrikeModel,
    strikes: NDArray[np.void],
    velocities: NDArray[np.float64],
    places: NDArray[np.float64],
) -> Cues | None:
    """
    Let cues follow their strokes; None if the scene turns that off.

    Parameters
    ----------
    model : StrikeModel
    strikes : (n,) Strike
    velocities : (n, 3) float array
        Of the strokes [m/s].
    places : (n, 3) float array
        Centres of the balls that were struck, at the end of the strike [m].

    """
    if not model.follows:
        return None
    played = strikes['status'] < Status.MISS
    axes = velocities[played]
    cues: NDArray[np.void] = ROWS.records(FollowingCue, len(strikes))
    cues['tip'], cues['reach'] = places + strikes['tip'], tip_reach(model)
    cues['axis'][played] = axes / np.linalg.norm(axes, axis=1)[:, np.newaxis]
    cues['speed'][played] = strikes['cue_speed'][played]
    cues['end'][played] = [follow_through_time(speed) for speed in cues['speed'][played].tolist()]

    def hit(table: Table, s: Simulation, axis: NDArray[np.float64]) -> None:
        _hit(model, table, s, axis)

    return Cues(cues, hit)


def _hit(model: StrikeModel, table: Table, s: Simulation, axis: NDArray[np.float64]) -> None:
    """
    Let the cue and ball 0 of a table meet, whose impact is pending, among balls and cushions.

    If the ball presses a nose, the impact begins when that began: the nose and the tip then act at
    once. From now to the end of the impact all bodies move evenly.
    """
    ball, cue, p, params = s.balls[0], s.cue, s.progress, table.params
    time, presses = float(p.time), ball.nose not in (NOTHING, IMPACT)
    if not presses:
        advance_free(table, ball, time)
    begin = float(ball.time)
    advance(cue, begin)
    before, motion = energy_of(params, ball), int(ball.motion)
    live = [0, *(i for i in range(1, len(s.balls)) if s.balls[i].motion <= FLIGHT)]
    places = np.array([position_at(s.balls[i], begin) for i in live])
    members, neighbours = neighbours_of(table, model, places)
    balls = [s.balls[live[member]] for member in members]
    states = Meeting(
        places[np.newaxis, members],
        np.array([[velocity_at(each, begin) for each in balls]]),
        np.array([[spin_at(each, begin) for each in balls]]),
        np.array([cue.position]),
        np.array([axis @ np.array(cue.velocity)]),
    )
    met = meet(model, axis[np.newaxis], states, np.array([TOLERANCE]), neighbours)
    after, lasting = met.after, max(begin + float(met.duration[0]) - time, 0.0)
    took_part = {0}
    for contact, closings in zip(neighbours, met.closings[0, TABLE + 1 :].tolist(), strict=True):
        if closings:
            took_part |= {contact.a} | ({contact.b} - {FIXED})
    for j in sorted(took_part):
        each = balls[j]
        advance_free(table, each, time)
        each.exit_velocity[:] = after.velocity[0, j].tolist()
        each.exit_spin[:] = after.spin[0, j].tolist()
        each.impact = p.events
        x, y, z = after.position[0, j].tolist()
        leave_impact(params, each, x, y, z, lasting)
    # An impact that is over by now leaves the ball, and the tip beside it, where the ball is.
    place = after.position[0, 0] if lasting > 0.0 else np.array(ball.position)
    cue.position[:] = (place + after.tip[0] - after.position[0, 0]).tolist()
    cue.time = time + lasting
    cue.velocity[:] = (after.speed[0] * axis).tolist()
    p.cue_hits += max(int(met.hits[0]), 1)
    if p.cue_hits >= MAX_HITS:
        cue.end = time
    if met.status[0] in (Status.BUDGET_EXCEEDED, Status.TOLERANCE_NOT_REACHED):
        p.flaw = int(met.status[0])
    left = kinetic_energy(params, ball.exit_velocity, ball.exit_spin)
    log_event(s, time, CUE, ball, NOTHING, before, left, motion)


def velocity_at(ball: Ball, time: float) -> list[float]:
    """Velocity [m/s] that a ball of the present segment has at a time."""
    return [
        v + a * (time - ball.time) for v, a in zip(ball.velocity, ball.acceleration, strict=True)
    ]


def spin_at(ball: Ball, time: float) -> list[float]:
    """Spin [rad/s] that a ball of the present segment has at a time."""
    return [
        w + a * (time - ball.time) for w, a in zip(ball.spin, ball.spin_acceleration, strict=True)
    ]
