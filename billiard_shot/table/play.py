"""
A table that is played to its end: event by event, in the order of their times.

Where times are equal the order is: ends of a ball's own motion, then what it meets of the table,
then what balls meet; among these in the order of the balls. Three or more bodies in touch are one
event (cluster.py). That order, and nothing else, decides; so runs are the same to the bit.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, fused
from billiard_shot.status import Status
from billiard_shot.table.furniture import Bed, Furniture, lay_out, lend_bed
from billiard_shot.table.given import INPUT
from billiard_shot.table.happen import end_motion, go_on, meet_ball, meet_table
from billiard_shot.table.motion import (
    ANGULAR,
    CLUSTER,
    END,
    HEIGHT,
    MOTION,
    OFF_TABLE,
    POSITION,
    START,
    VELOCITY,
)
from billiard_shot.table.rails import NOTHING
from billiard_shot.table.roll_out import ending
from billiard_shot.table.surface import Surface
from billiard_shot.table.world import lend_world, PAUSED, schedule_meetings, World

OK = int(Status.OK)
BUDGET_EXCEEDED = int(Status.BUDGET_EXCEEDED)
WAITING = -1
TABLE_OFF = int(Status.OFF_TABLE)
INVALID_REQUEST = int(Status.INVALID_REQUEST)

RESULT = 10  # columns of a result: position, velocity, spin, motion
DEEPEST = 1e-9  # m: overlap that a given state may have by rounding


@fused
def next_event(w: World) -> tuple[float, int, int]:
    """When something happens next, and to which ball; with another one, or itself, or no one."""
    time, ball, other = np.inf, NOTHING, NOTHING
    count = w.balls.shape[0]
    for i in range(count):
        if w.balls[i, END] < time:
            time, ball, other = w.balls[i, END], i, NOTHING
    for i in range(count):
        if w.rail_time[i] < time:
            time, ball, other = w.rail_time[i], i, i
    for i in range(count):
        for j in range(i + 1, count):
            if w.meet[i, j] < time:
                time, ball, other = w.meet[i, j], i, j
    return time, ball, other


@fused
def resume(
    surface: Surface, furniture: Furniture, bed: Bed, w: World, cause: int, now: float,
    tolerance: float, hop: float,
) -> None:
    """Let the balls that were touched go on."""
    for i in range(w.balls.shape[0]):
        if w.touched[i]:
            go_on(surface, furniture, bed, w, i, cause, tolerance, hop)
    for i in range(w.balls.shape[0]):
        if w.touched[i]:
            schedule_meetings(w, i, now, 2.0 * surface.radius, furniture.pairs)
        w.touched[i] = False
    w.pause[0] = 0.0


@fused
def play(
    surface: Surface, furniture: Furniture, bed: Bed, w: World, tolerance: float, hop: float,
    limit: int,
) -> tuple[float, int]:
    """
    Play until nothing moves, or only endlessly, or several bodies meet.

    Return when that is, and the status: of the table, or WAITING.
    """
    diameter = 2.0 * surface.radius
    now = w.pause[1]
    if w.pause[0] < 0.0:
        unsolved = int(-w.pause[0])
        w.pause[0] = 0.0
        return now, unsolved
    resume(
        surface, furniture, bed, w, CLUSTER if w.pause[0] == PAUSED else START, now, tolerance, hop
    )
    while True:
        time, i, j = next_event(w)
        if time == np.inf:
            break
        if w.counts[1] >= limit:
            return now, BUDGET_EXCEEDED
        now = time
        if j == NOTHING:
            end_motion(surface, furniture, bed, w, i, tolerance, hop)
        elif j == i:
            meet_table(surface, furniture, bed, w, i, tolerance, hop)
        else:
            meet_ball(surface, furniture, bed, w, i, j, now, tolerance, hop)
        if w.pause[0] == PAUSED:
            return now, WAITING
        schedule_meetings(w, i, now, diameter, furniture.pairs)
        if j not in (NOTHING, i):
            schedule_meetings(w, j, now, diameter, furniture.pairs)
    status = OK
    for i in range(w.balls.shape[0]):
        own = ending(surface, w.balls[i])
        if w.balls[i, MOTION] == OFF_TABLE:
            own = TABLE_OFF
        status = max(status, own)
    return now, status


@fused
def set_up(
    surface: Surface, w: World, states: NDArray[np.float64], table: int
) -> bool:
    """Put balls where they are given to be; return whether they can be there."""
    count = w.balls.shape[0]
    for i in range(count):
        ball = w.balls[i]
        for k in range(ball.shape[0]):
            ball[k] = 0.0
        for k in range(3):
            ball[POSITION + k] = states[table, i, k]
            ball[VELOCITY + k] = states[table, i, 3 + k]
            ball[ANGULAR + k] = states[table, i, 6 + k]
        for k in range(INPUT):
            if not np.isfinite(states[table, i, k]):
                return False
        if ball[HEIGHT] < surface.radius * (1.0 - 1e-6):
            return False
        w.pocket[i], w.first[i], w.touched[i] = NOTHING, NOTHING, True
        for j in range(i):
            square = 0.0
            for k in range(3):
                square += (ball[POSITION + k] - w.balls[j, POSITION + k]) ** 2
            if np.sqrt(square) < 2.0 * surface.radius - DEEPEST:
                return False
    w.counts[1], w.counts[2] = 0, 0  # segments go on: those of all tables follow each other
    w.pause[:] = 0.0
    return True


@entry
def play_tables(
    surface: Surface,
    furniture: Furniture,
    states: NDArray[np.float64],
    table: int,
    tolerance: float,
    hop: float,
    limit: int,
    world: World,
    results: NDArray[np.float64],
    summary: NDArray[np.float64],
    places: NDArray[np.int64],
) -> int:
    """
    Play tables, one after the other, each to its end or until several bodies meet.

    Parameters
    ----------
    surface, furniture : Surface, Furniture
    states : (tables, balls, INPUT) float array
    table : int
        The first one to play; where `world` has paused, it is the one that goes on.
    tolerance, hop : float
        For leaving out bounces of a ball that flies, and hops after impacts [m].
    limit : int
        Most events of a table.
    world : World, changed
        Its segments are those of all tables, its events of the last one, as far as there is room.
    results : (tables, balls, RESULT) float array, written
    summary : (tables, 5) float array, written
        Duration [s], status, number of segments so far, of events, and of contacts looked for.
    places : (tables, balls, 2) int array, written
        The pocket in which each ball lies, and the first ball it met; or NOTHING.

    Returns
    -------
    table : int
        The one that has paused, or the number of tables: all are played.

    """
    laid_out = lay_out(furniture, surface.radius)
    bed, w = lend_bed(laid_out), lend_world(world)
    while table < states.shape[0]:
        if w.pause[0] != 0.0 or set_up(surface, w, states, table):
            summary[table, 0], summary[table, 1] = play(
                surface, furniture, bed, w, tolerance, hop, limit
            )
            if w.pause[0] == PAUSED:
                break
        else:
            summary[table, 0], summary[table, 1] = 0.0, INVALID_REQUEST
        for k in range(3):
            summary[table, 2 + k] = w.counts[k]
        for i in range(w.balls.shape[0]):
            for k in range(3):
                results[table, i, k] = w.balls[i, POSITION + k]
                results[table, i, 3 + k] = w.balls[i, VELOCITY + k]
                results[table, i, 6 + k] = w.balls[i, ANGULAR + k]
            results[table, i, 9] = w.balls[i, MOTION]
            places[table, i, 0] = w.pocket[i]
            places[table, i, 1] = w.first[i]
        table += 1
    w.counts[0] += laid_out.arcs.shape[0] * 0  # so that the table stays until here
    return table
