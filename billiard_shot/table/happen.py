"""
What happens to balls on the table: a motion that ends, a meeting, and how each goes on from there.

Balls that meet slowly stay together, and are set apart by a micrometre; an impact of more than two
bodies is left to cluster.py.
"""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.airborne import off_bed
from billiard_shot.table.balls import away, normal_of, strike_each_other
from billiard_shot.table.cushion import strike_cushion, touch_edge
from billiard_shot.table.flight import bounce, error_of_pause
from billiard_shot.table.furniture import Bed, Furniture
from billiard_shot.table.motion import (
    advance,
    BALL,
    CAUSE,
    CLIMB,
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
from billiard_shot.table.sphere import LEAST_APPROACH
from billiard_shot.table.steps import begin, finish
from billiard_shot.table.surface import AUTO, Surface
from billiard_shot.table.surface import OFF as NEVER
from billiard_shot.table.world import (
    energy_of,
    log_event,
    near_others,
    PAUSED,
    place_at,
    schedule_rail,
    World,
    write_down,
)

APART = 1e-6  # m, between bodies that met slowly: so far they are set apart


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
    w.pause[0], w.pause[1], w.pause[2], w.pause[3] = PAUSED, time, ball, other


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
    lies = ball[HEIGHT] == surface.radius  # one in the air strikes the cushion by itself
    if lies and 0 <= what < HOLES and near_others(w, index, index, ball[TIME], reach):
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
