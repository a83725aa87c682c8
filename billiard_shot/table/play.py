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
from billiard_shot.table.airborne import off_bed
from billiard_shot.table.balls import away, normal_of, strike_each_other
from billiard_shot.table.cushion import strike_cushion, touch_edge
from billiard_shot.table.flight import bounce, error_of_pause
from billiard_shot.table.furniture import Bed, Furniture, lay_out, lend_bed
from billiard_shot.table.motion import (
    advance,
    ANGULAR,
    BALL,
    CAUSE,
    CLIMB,
    CLUSTER,
    CUSHION,
    END,
    FALL,
    FLIGHT,
    halt,
    HEIGHT,
    HOPS,
    MOTION,
    OFF,
    OFF_TABLE,
    OWN,
    POCKET,
    POCKETED,
    POSITION,
    START,
    TIME,
    VELOCITY,
)
from billiard_shot.table.rails import HOLES, NOTHING, on_nose, OUTSIDE
from billiard_shot.table.roll_out import ending
from billiard_shot.table.sphere import LEAST_APPROACH
from billiard_shot.table.steps import begin, finish
from billiard_shot.table.surface import AUTO, Surface
from billiard_shot.table.surface import OFF as NEVER
from billiard_shot.table.world import (
    energy_of,
    lend_world,
    log_event,
    near_others,
    place_at,
    schedule_meetings,
    schedule_rail,
    World,
    write_down,
)

OK = int(Status.OK)
BUDGET_EXCEEDED = int(Status.BUDGET_EXCEEDED)
PAUSED = -1
TABLE_OFF = int(Status.OFF_TABLE)
INVALID_REQUEST = int(Status.INVALID_REQUEST)

INPUT = 9  # columns of a given state: position, velocity, spin
RESULT = 10  # columns of a result: position, velocity, spin, motion
APART = 1e-6  # m, between bodies that met slowly: so far they are set apart
DEEPEST = 1e-9  # m: overlap that a given state may have by rounding


@fused
def calm(surface: Surface, ball: NDArray[np.float64], tolerance: float) -> None:
    """
    Let the cloth answer to an impact that pushed a ball into it or off it.

    Hops that are not worth resolving are left out, with the little that the cloth does in them.
    """
    ball[HOPS] = 0.0
    ball[FALL] = 0.0
    if ball[HEIGHT] > surface.radius or ball[CLIMB] == 0.0:
        return
    small = surface.flight == AUTO and error_of_pause(surface, ball, abs(ball[CLIMB])) <= tolerance
    if small or surface.flight == NEVER:
        ball[CLIMB] = 0.0
    elif ball[CLIMB] < 0.0:
        bounce(surface, ball)
        ball[HOPS] = 0.0


@fused
def go_on(
    surface: Surface, furniture: Furniture, bed: Bed, w: World, index: int, cause: int,
    tolerance: float, hop: float,
) -> None:
    """Begin the motion that follows an event, and find what its ball meets of the table."""
    ball = w.balls[index]
    ball[CAUSE] = cause
    if ball[MOTION] <= FLIGHT:
        if cause not in (OWN, START):
            calm(surface, ball, hop)
        begin(surface, ball, tolerance)
    write_down(w, index)
    schedule_rail(surface, furniture, bed, w, index)


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
def end_motion(
    surface: Surface, furniture: Furniture, bed: Bed, w: World, index: int, tolerance: float,
    hop: float,
) -> None:
    """Let a ball's motion end by itself."""
    ball = w.balls[index]
    before_motion = ball[MOTION]
    lands_outside = False
    advance(ball, ball[END])
    before = energy_of(surface, ball)
    if before_motion == FLIGHT and furniture.length < np.inf:
        lands_outside = off_bed(bed, ball)
    if lands_outside:
        halt(ball, OFF_TABLE)
        cause = OFF
    else:
        finish(surface, ball)
        cause = OWN
    after = energy_of(surface, ball)
    go_on(surface, furniture, bed, w, index, cause, tolerance, hop)
    log_event(
        w, ball[TIME], cause, index, NOTHING, 2.0**index, before, after,
        before_motion + 8.0 * ball[MOTION],
    )


@fused
def set_apart(
    w: World, bed: Bed, radius: float, index: int, space: float, x: float, y: float, z: float
) -> None:
    """Shift a ball by half of a space along (x, y, z), if nothing is in its way."""
    ball, shift = w.balls[index], 0.5 * space
    px, py, pz = ball[POSITION] + shift * x, ball[POSITION + 1] + shift * y, ball[HEIGHT]
    if ball[HEIGHT] > radius:
        pz += shift * z
    if bed.reach > 0.0 and (abs(px) > bed.x or abs(py) > bed.y):
        return
    for other in range(w.balls.shape[0]):
        if other == index or w.balls[other, MOTION] > FLIGHT:
            continue
        u, v, t = place_at(w.balls[other], ball[TIME])
        u, v, t = px - u, py - v, pz - t
        inside = u * u + v * v + t * t <= 4.0 * radius * radius
        if inside and u * x + v * y + t * z < 0.0:
            return
    ball[POSITION], ball[POSITION + 1], ball[HEIGHT] = px, py, pz


@fused
def bump(
    surface: Surface, furniture: Furniture, bed: Bed, w: World, index: int, what: int
) -> None:
    """Let a ball strike a nose, facing or arc."""
    ball = w.balls[index]
    x, y, z, lying = touch_edge(furniture, bed, surface.radius, ball, what)
    approach = -(ball[VELOCITY] * x + ball[VELOCITY + 1] * y + ball[CLIMB] * z)
    slow = approach <= LEAST_APPROACH
    e = 0.0 if slow else furniture.cushion_restitution
    strike_cushion(surface, furniture, ball, lying, x, y, z, e)
    if slow and lying:
        set_apart(w, bed, surface.radius, index, 2.0 * APART, x, y, 0.0)


@fused
def pause(w: World, time: float, ball: int, other: int) -> None:
    """Stop for an impact of three bodies or more."""
    w.pause[0], w.pause[1], w.pause[2], w.pause[3] = 1.0, time, ball, other


@fused
def crowded(
    surface: Surface, furniture: Furniture, bed: Bed, w: World, i: int, j: int, time: float
) -> bool:
    """Whether either of two balls that meet touches another one, or a nose."""
    reach = 2.0 * surface.radius + furniture.gap
    if near_others(w, i, j, time, reach) or near_others(w, j, i, time, reach):
        return True
    for ball in (w.balls[i], w.balls[j]):
        x, y, z = place_at(ball, time)
        for nose in range(4):
            out = abs(x) - bed.x if nose < 2 else abs(y) - bed.y
            if z == surface.radius and abs(out) <= furniture.gap and on_nose(bed, nose, x, y):
                return True
    return False


@fused
def meet_table(
    surface: Surface, furniture: Furniture, bed: Bed, w: World, index: int, tolerance: float,
    hop: float,
) -> None:
    """Let a ball meet something of the table."""
    ball, what = w.balls[index], w.rail[index]
    advance(ball, w.rail_time[index])
    before, motion = energy_of(surface, ball), ball[MOTION]
    reach = 2.0 * surface.radius + furniture.gap
    if 0 <= what < HOLES and near_others(w, index, index, ball[TIME], reach):
        pause(w, ball[TIME], index, index)
        return
    if what == OUTSIDE:
        cause, what = OFF, NOTHING
        halt(ball, OFF_TABLE)
    elif what >= HOLES:
        cause, what = POCKET, what - HOLES
        w.pocket[index] = what
        halt(ball, POCKETED)
    else:
        cause = CUSHION
        bump(surface, furniture, bed, w, index, what)
    after = energy_of(surface, ball)
    go_on(surface, furniture, bed, w, index, cause, tolerance, hop)
    log_event(
        w, ball[TIME], cause, index, what, 2.0**index, before, after, motion + 8.0 * ball[MOTION]
    )


@fused
def meet_ball(
    surface: Surface, furniture: Furniture, bed: Bed, w: World, i: int, j: int, time: float,
    tolerance: float, hop: float,
) -> None:
    """Let two balls meet."""
    a, b = w.balls[i], w.balls[j]
    advance(a, time)
    advance(b, time)
    before, motion = energy_of(surface, a) + energy_of(surface, b), a[MOTION]
    x, y, z, distance = normal_of(a, b)
    approach = -away(a, b, VELOCITY, x, y, z)
    slow = approach <= LEAST_APPROACH
    if not slow and crowded(surface, furniture, bed, w, i, j, time):
        pause(w, time, i, j)
        return
    strike_each_other(
        surface, furniture, a, b, 0.0 if slow else furniture.ball_restitution
    )
    if slow:
        space = APART - distance + 2.0 * surface.radius
        set_apart(w, bed, surface.radius, i, space, x, y, z)
        set_apart(w, bed, surface.radius, j, space, -x, -y, -z)
    for one, other in ((i, j), (j, i)):
        if w.first[one] == NOTHING:
            w.first[one] = other
        go_on(surface, furniture, bed, w, one, BALL, tolerance, hop)
    after = energy_of(surface, a) + energy_of(surface, b)
    log_event(
        w, time, BALL, i, j, 2.0**i + 2.0**j, before, after, motion + 8.0 * a[MOTION]
    )


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

    Return when that is, and the status: of the table, or PAUSED.
    """
    diameter = 2.0 * surface.radius
    now = w.pause[1]
    resume(
        surface, furniture, bed, w, CLUSTER if w.pause[0] > 0.0 else START, now, tolerance, hop
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
        if w.pause[0] > 0.0:
            return now, PAUSED
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
    w.counts[:] = 0
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
        Its record is that of the last table, as far as there is room.
    results : (tables, balls, RESULT) float array, written
    summary : (tables, 5) float array, written
        Duration [s], status, numbers of segments, of events, and of contacts looked for.
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
        if w.pause[0] > 0.0 or set_up(surface, w, states, table):
            summary[table, 0], summary[table, 1] = play(
                surface, furniture, bed, w, tolerance, hop, limit
            )
            if w.pause[0] > 0.0:
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
