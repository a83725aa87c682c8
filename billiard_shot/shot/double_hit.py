"""
The cue that follows its stroke, and may hit the ball again: a double hit, a foul in most games.

After the strike the cue goes on along its line with the speed that the strike left it, as far as
players follow through. The ball may have met another ball close in front, or come back with draw
or from a cushion, or the table may have thrown it against the cue. What follows is simulated as
any other event; the impact is that of cue_contact.py.
"""

import numpy as np
from numpy.typing import NDArray

from billiard_shot.shot.cue_contact import MAX_HITS, meet, Meeting, TOLERANCE
from billiard_shot.shot.model import StrikeModel, tip_reach
from billiard_shot.shot.strike import follow_through_time
from billiard_shot.status import Status
from billiard_shot.table.cushion import advance_free
from billiard_shot.table.geometry import Table
from billiard_shot.table.motion import advance, CUE, NOTHING
from billiard_shot.table.simulate import Cues
from billiard_shot.table.simulation_state import CUE_COLUMNS, energy_of, log_event, Simulation


def following_cues(
    model: StrikeModel,
    strikes: NDArray[np.void],
    velocities: NDArray[np.float64],
    centre: NDArray[np.float64],
) -> Cues | None:
    """
    Let cues follow their strokes; None if the scene turns that off.

    Parameters
    ----------
    model : StrikeModel
    strikes : (n,) Strike
    velocities : (n, 3) float array
        Of the strokes [m/s].
    centre : (3,) float array
        Of the ball that was struck [m].

    """
    if not model.follows:
        return None
    speeds = strikes['cue_speed']
    sizes = np.linalg.norm(velocities, axis=1)
    cues = np.zeros((len(strikes), CUE_COLUMNS))
    cues[:, :3] = centre + strikes['tip']
    with np.errstate(invalid='ignore', divide='ignore'):
        cues[:, 3:6] = np.where(sizes > 0.0, speeds / sizes, 0.0)[:, np.newaxis] * velocities
    played = strikes['status'] < Status.MISS
    cues[:, 6] = [
        follow_through_time(speed) if ok else 0.0
        for speed, ok in zip(speeds.tolist(), played.tolist(), strict=True)
    ]
    cues[:, 7] = tip_reach(model)

    def hit(table: Table, s: Simulation) -> None:
        _hit(model, table, s)

    return Cues(cues, hit)


def _hit(model: StrikeModel, table: Table, s: Simulation) -> None:
    """Let the cue and ball 0 of a table meet, whose impact is pending."""
    ball, cue, p, params = s.balls[0], s.cue, s.progress, table.params
    time = float(p.time)
    advance_free(table, ball, time)
    advance(cue, time)
    before, motion = energy_of(params, ball), int(ball.motion)
    velocity = np.array(cue.velocity)
    speed = float(np.linalg.norm(velocity))
    axis = velocity / speed
    place = np.array(ball.position)
    states = Meeting(
        place[np.newaxis],
        np.array([ball.velocity]),
        np.array([ball.spin]),
        np.array([cue.position]),
        np.array([speed]),
    )
    met = meet(model, axis[np.newaxis], states, np.array([TOLERANCE]))
    after = met.after
    rest = float(after.speed[0])
    tip = place + after.tip[0] - after.position[0]
    for k in range(3):
        ball.velocity[k], ball.spin[k] = float(after.velocity[0, k]), float(after.spin[0, k])
        cue.position[k], cue.velocity[k] = float(tip[k]), rest * float(axis[k])
    p.cue_hits += max(int(met.hits[0]), 1)
    if rest <= 0.0 or p.cue_hits >= MAX_HITS:
        cue.end = time
    if met.status[0] in (Status.BUDGET_EXCEEDED, Status.TOLERANCE_NOT_REACHED):
        p.unsolved = int(met.status[0])
    ball.modified = True
    log_event(s, time, CUE, ball, NOTHING, before, energy_of(params, ball), motion)
