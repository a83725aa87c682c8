"""The balls on the table while it is played, when each meets something next, and the record."""
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import fused
from billiard_shot.table.airborne import next_of_flight
from billiard_shot.table.balls import meeting
from billiard_shot.table.furniture import Bed, Furniture
from billiard_shot.table.lent import lent
from billiard_shot.table.motion import (
    ACCELERATION,
    ANGULAR,
    COLUMNS,
    END,
    FLIGHT,
    MOTION,
    POSITION,
    REST,
    SPIN,
    STATE,
    TIME,
    VELOCITY,
)
from billiard_shot.table.rails import next_of_table, NOTHING
from billiard_shot.table.surface import OFF, ON, Surface

# columns of an event: what it was (a Cause), ball, what it met (a ball, a part of the table), the
# balls that took part (a sum of powers of two), their kinetic energy before and after it [J]
EVENT_TIME, EVENT_CAUSE, EVENT_BALL, EVENT_OTHER, EVENT_BALLS, BEFORE, AFTER = range(7)
EVENT_MOTIONS = 7  # of the ball: before + 8 after
EVENT_COLUMNS = 8

PAUSED = 1.0  # a play that waits for a collision


class World(NamedTuple):
    """State of n balls."""

    balls: NDArray[np.float64]  # (n, STATE)
    rail_time: NDArray[np.float64]  # (n,) when each meets something of the table
    rail: NDArray[np.int64]  # (n,) and what
    meet: NDArray[np.float64]  # (n, n) when each pair meets, above the diagonal
    pocket: NDArray[np.int64]  # (n,) in which a ball lies, or NOTHING
    first: NDArray[np.int64]  # (n,) the first ball that each one met, or NOTHING
    counts: NDArray[np.int64]  # (3,) segments, events, and contacts looked for so far
    segments: NDArray[np.float64]  # (segments, COLUMNS + 1) the last column: which ball
    events: NDArray[np.float64]  # (events, EVENT_COLUMNS)
    # Where three bodies or more meet, the play pauses for cluster.py: (4,) PAUSED if it does,
    # or minus the status of a collision that was not solved, when, the ball and the one it met
    # (itself: a cushion); (n,) who took part.
    pause: NDArray[np.float64]
    touched: NDArray[np.bool_]


def empty_world(
    count: int, segments: NDArray[np.float64], events: NDArray[np.float64]
) -> World:
    """World of some balls that records as much as there is room for."""
    return World(
        np.zeros((count, STATE)), np.full(count, np.inf), np.full(count, NOTHING, np.int64),
        np.full((count, count), np.inf), np.full(count, NOTHING, np.int64),
        np.full(count, NOTHING, np.int64), np.zeros(3, np.int64), segments, events,
        np.zeros(4), np.zeros(count, np.bool_),
    )


@fused
def lend_world(w: World) -> World:
    """Return the same world, whose arrays nobody counts; the world itself has to stay."""
    return World(
        lent(w.balls), lent(w.rail_time), lent(w.rail), lent(w.meet), lent(w.pocket),
        lent(w.first), lent(w.counts), lent(w.segments), lent(w.events),
        lent(w.pause), lent(w.touched),
    )


@fused
def energy_of(surface: Surface, ball: NDArray[np.float64]) -> float:
    """Kinetic energy of a ball [J]."""
    moving, turning = 0.0, 0.0
    for i in range(3):
        moving += ball[VELOCITY + i] ** 2
        turning += ball[ANGULAR + i] ** 2
    return 0.5 * (surface.mass * moving + surface.inertia * turning)


@fused
def write_down(w: World, index: int) -> None:
    """Record a ball's motion as its next segment."""
    row = w.counts[0]
    if row < w.segments.shape[0]:
        for i in range(COLUMNS):
            w.segments[row, i] = w.balls[index, i]
        w.segments[row, COLUMNS] = index
    w.counts[0] += 1


@fused
def place_at(ball: NDArray[np.float64], time: float) -> tuple[float, float, float]:
    """Where a ball's centre is at a time, in its present motion."""
    dt = time - ball[TIME]
    half = 0.5 * dt
    return (
        ball[POSITION] + dt * (ball[VELOCITY] + half * ball[ACCELERATION]),
        ball[POSITION + 1] + dt * (ball[VELOCITY + 1] + half * ball[ACCELERATION + 1]),
        ball[POSITION + 2] + dt * (ball[VELOCITY + 2] + half * ball[ACCELERATION + 2]),
    )


@fused
def near_others(w: World, index: int, besides: int, time: float, reach: float) -> bool:
    """Whether a ball is within reach of any other one, besides one."""
    x, y, z = place_at(w.balls[index], time)
    for other in range(w.balls.shape[0]):
        if other in (index, besides) or w.balls[other, MOTION] > FLIGHT:
            continue
        p, q, r = place_at(w.balls[other], time)
        if (x - p) ** 2 + (y - q) ** 2 + (z - r) ** 2 <= reach * reach:
            return True
    return False


@fused
def log_event(
    w: World, time: float, cause: int, ball: int, other: int, balls: float, before: float,
    after: float, motions: float,
) -> None:
    """Record an event."""
    row = w.counts[1]
    if row < w.events.shape[0]:
        w.events[row, EVENT_TIME] = time
        w.events[row, EVENT_CAUSE] = cause
        w.events[row, EVENT_BALL] = ball
        w.events[row, EVENT_OTHER] = other
        w.events[row, EVENT_BALLS] = balls
        w.events[row, BEFORE] = before
        w.events[row, AFTER] = after
        w.events[row, EVENT_MOTIONS] = motions
    w.counts[1] += 1


@fused
def moves(ball: NDArray[np.float64]) -> bool:
    """Whether a ball's centre moves."""
    motion = ball[MOTION]
    return bool(motion != REST and motion != SPIN and motion <= FLIGHT)


@fused
def schedule_rail(
    surface: Surface, furniture: Furniture, bed: Bed, w: World, index: int
) -> None:
    """Find when a ball, in its present motion, meets something of the table."""
    ball = w.balls[index]
    if furniture.length == np.inf or not moves(ball):
        w.rail_time[index], w.rail[index] = np.inf, NOTHING
    elif ball[MOTION] == FLIGHT and ball[ACCELERATION + 2] != 0.0:
        w.rail_time[index], w.rail[index] = next_of_flight(bed, furniture, surface.radius, ball)
    else:
        w.rail_time[index], w.rail[index], looked = next_of_table(bed, furniture.depth, ball)
        w.counts[2] += looked


@fused
def schedule_meetings(w: World, index: int, now: float, diameter: float, pairs: int) -> None:
    """
    Find when a ball meets each other one, before either does something else anyway.

    `pairs`: ON looks at every pair, and to the end of its motions; OFF at none.
    """
    if pairs == OFF:
        return
    until = w.balls[index, END]
    if pairs != ON:
        until = min(until, w.rail_time[index])
    here, moving = w.balls[index, MOTION] <= FLIGHT, moves(w.balls[index])
    for other in range(w.balls.shape[0]):
        if other == index:
            continue
        time = np.inf
        near = moving or moves(w.balls[other]) or pairs == ON
        if here and w.balls[other, MOTION] <= FLIGHT and near:
            end = min(until, w.balls[other, END])
            if pairs != ON:
                end = min(end, w.rail_time[other])
            w.counts[2] += 1
            time = meeting(w.balls[index], w.balls[other], now, end, diameter)
        w.meet[min(index, other), max(index, other)] = time
