"""Many strokes, one after the other, each at a ball in the same place among the same others."""

import threading

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.kernel import solve_collisions
from billiard_shot.impact.state import PhaseLog
from billiard_shot.records import as_rows, ROWS, Storage
from billiard_shot.shot.model import cue_params
from billiard_shot.shot.moving_strikes import with_moving_bodies
from billiard_shot.shot.strike import (
    BODIES,
    CONTACTS,
    PHASE_ROOM,
    strike_balls,
    Strikes,
    Strokes,
)
from billiard_shot.table.cluster import impact_room
from billiard_shot.table.cue import CueParams, CueRecord, NO_CUE
from billiard_shot.table.gather import ImpactRoom
from billiard_shot.table.initial_states import ball_starts
from billiard_shot.table.model import ENDLESS
from billiard_shot.table.params import TableParams
from billiard_shot.table.run import EventLog
from billiard_shot.table.simulation_state import EventRecord

NO_BALLS = np.zeros((0, 3))
NO_PHASES = ROWS.records(PhaseLog, 0).reshape(0, CONTACTS)
NO_EVENTS = EventLog(ROWS.records(EventRecord, 0), np.zeros((0, 2), np.int64))


def strike_batch(
    strokes: Strokes,
    tolerance: float,
    table: TableParams = ENDLESS,
    others: NDArray[np.float64] = NO_BALLS,
    recorded: bool = False,
) -> Strikes:
    """
    Strike the ball with each stroke, by default with nothing but the cloth near it.

    A refused stroke leaves the ball where it is. A row of normals or velocities that is none (not
    finite, or zero) gets the status INVALID_STROKE.

    Parameters
    ----------
    strokes : Strokes
    tolerance : float
        Of the trajectories [m].
    table : TableParams
    others : (balls, 3) float array
        Centres of the other balls [m].
    recorded : bool
        Whether the last strike is recorded in detail.

    """
    params = cue_params(strokes.model, table)
    cues, log = strike_alone(strokes, params, tolerance, PHASE_ROOM if recorded else 0)
    starts = starts_of(strokes.position, others, len(cues))
    starts['velocity'][:, 0], starts['spin'][:, 0] = cues['velocity'], cues['spin']
    losses = cues['losses'][-1:].reshape(-1, 2)
    alone = Strikes(params, cues, starts, log, losses, NO_EVENTS)
    return with_moving_bodies(strokes, tolerance, table, alone, recorded)


def starts_of(
    place: NDArray[np.float64], others: NDArray[np.float64], tables: int
) -> NDArray[np.void]:
    """Make (tables, balls) BallStart: the struck ball at a place (3,), and others (balls, 3)."""
    starts = ball_starts(tables, 1 + len(others))
    starts['position'][:, 0], starts['position'][:, 1:] = place, others
    return starts


def strike_alone(
    strokes: Strokes, params: CueParams, tolerance: float, phases: int = 0
) -> tuple[NDArray[np.void], NDArray[np.void]]:
    """
    Strike the ball with nothing but the cloth near it; parameters as of `strike_balls`.

    Returns the cues (n,) after their strikes, and the log (phases, CONTACTS) of the last one, if
    there is room for phases; if there are more, it is struck again.
    """
    run = strike_balls.current()
    storage, n = run.storage, len(strokes.normals)
    given, solver = strokes.stored(storage), solve_collisions.as_argument(storage)
    room, cues = _thread.room(storage), storage.records(CueRecord, n)
    while True:
        if phases:
            log = storage.records(PhaseLog, phases * CONTACTS)
            room = room._replace(results=room.results._replace(log=log))
        run(given, params, tolerance, room, cues, solver)
        rows = as_rows(CueRecord, cues)
        needed = int(rows['phases'][-1]) if phases and n else 0
        if needed <= phases:
            break
        phases = needed
    if not phases:
        return rows, NO_PHASES
    return rows, as_rows(PhaseLog, log)[: needed * CONTACTS].reshape(needed, CONTACTS)


class _Thread(threading.local):
    """Room of this thread: to make it anew takes longer than a strike."""

    def __init__(self) -> None:
        self.kept: dict[Storage, ImpactRoom] = {}

    def room(self, storage: Storage) -> ImpactRoom:
        """Return room for a strike; its contents are those of the last one."""
        if storage not in self.kept:
            self.kept[storage] = impact_room(storage, 1, BODIES, CONTACTS)
        return self.kept[storage]


_thread = _Thread()


def refusals(strokes: Strokes) -> NDArray[np.int64]:
    """Find the status (n,) with which each stroke would be refused, or OK; see `strike_batch`."""
    status: NDArray[np.int64] = strike_alone(strokes, NO_CUE, 0.0)[0]['status']
    return status
