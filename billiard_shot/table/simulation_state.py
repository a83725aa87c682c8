"""The state of a table that is simulated: balls, when each meets something next, the record."""

import math
from typing import Any, NamedTuple

from billiard_shot.compiled import inner, innermost
from billiard_shot.records import record, Storage, Vector
from billiard_shot.table.ball_collision import collision_time
from billiard_shot.table.flight_boundary import next_flight_boundary
from billiard_shot.table.geometry import TableModel
from billiard_shot.table.motion import (
    BallRecord,
    FLIGHT,
    IMPACT,
    NOTHING,
    RELEASE,
    REST,
    SegmentRecord,
    SPIN,
    write_segment,
)
from billiard_shot.table.params import BallClothParams, GATE_OFF, GATE_ON
from billiard_shot.table.rebound import Rebound
from billiard_shot.table.rolling_boundary import next_rolling_boundary


@record
class EventRecord:
    """Something that happened on the table."""

    time: float  # s
    cause: int  # Cause
    ball: int  # index
    other: int  # index of the ball, feature or pocket that it met, or NOTHING
    energy_before: float  # J, kinetic, of the balls that took part
    energy_after: float
    motion_before: int  # Motion, of the ball
    motion_after: int


@record
class RunProgress:
    """How far a simulation is; all counts are so far, and of this table but for the segments."""

    segments: int  # of all tables
    events: int
    searches: int  # contacts looked for
    participants: int  # of impacts of several balls
    double_hit: bool  # the cue hit ball 0 again, in the strike or later; chatter does not count
    cue_touches: int  # without the strike
    unsolved: int  # Status of an impact that was not solved, or OK
    flaw: int  # Status of an impact that was solved, but with a flaw, or OK


@record
class BallRule:
    """
    What a ball must do, or not, for a run that ends as soon as that is decided.

    Ball 0 is the one that was struck.
    """

    must_stay: bool  # the run ends if it is pocketed
    barred: bool  # the run ends if ball 0 meets it before any other ball
    # It is to be pocketed: the run ends if all such balls that were met rest, or met more than
    # this many straight cushions. 0: it need not be pocketed.
    sought: int


class Simulation(NamedTuple):
    """State of n balls."""

    balls: list[BallRecord]
    collisions: Any  # (n, n) when each pair meets [s], above the diagonal
    progress: RunProgress
    rebound: Rebound  # room for a contact with a cushion
    segments: list[SegmentRecord]  # of all tables, as far as there is room
    events: list[EventRecord]  # of this table, as far as there is room
    rules: list[BallRule]  # of each ball, or none: the run goes on until all rest
    # The sphere of the tip, which follows its stroke until its `end`. It meets ball 0 next at its
    # `meeting_time`.
    cue: BallRecord


class SimulationRoom(NamedTuple):
    """Room for a `Simulation`, as compiled code is given it."""

    balls: list[BallRecord]
    collisions: Any
    progress: list[RunProgress]  # 1
    rebound: list[Rebound]  # 1
    cue: list[BallRecord]  # 1


def room_for_simulation(storage: Storage, balls: int) -> SimulationRoom:
    """Make room for so many balls."""
    return SimulationRoom(
        storage.records(BallRecord, balls),
        storage.zeros(balls, balls),
        storage.records(RunProgress, 1),
        storage.records(Rebound, 1),
        storage.records(BallRecord, 1),
    )


@inner
def kinetic_energy(params: BallClothParams, velocity: Vector, spin: Vector) -> float:
    """Kinetic energy [J] of a ball with a velocity [m/s] and a spin [rad/s]."""
    moving, turning = 0.0, 0.0
    for i in range(3):
        moving += velocity[i] * velocity[i]
        turning += spin[i] * spin[i]
    return 0.5 * (params.mass * moving + params.inertia * turning)


@innermost
def energy_of(params: BallClothParams, ball: BallRecord) -> float:
    """Kinetic energy of a ball [J]."""
    return kinetic_energy(params, ball.velocity, ball.spin)


@inner
def log_segment(s: Simulation, ball: BallRecord) -> None:
    """Record a ball's motion as its next segment."""
    if s.progress.segments < len(s.segments):
        write_segment(ball, s.segments[s.progress.segments])
    s.progress.segments += 1


@inner
def log_event(
    s: Simulation,
    time: float,
    cause: int,
    ball: BallRecord,
    other: int,
    before: float,
    after: float,
    motion: int,
) -> None:
    """Record an event; `motion`: what the ball did before it."""
    if s.progress.events < len(s.events):
        event = s.events[s.progress.events]
        event.time, event.cause, event.ball, event.other = time, cause, ball.ball, other
        event.energy_before, event.energy_after = before, after
        event.motion_before, event.motion_after = motion, ball.motion
    s.progress.events += 1


@innermost
def position_at(ball: BallRecord, time: float) -> tuple[float, float, float]:
    """Where a ball's centre is at a time, in its present segment [m]."""
    dt = time - ball.time
    half = 0.5 * dt
    p, v, a = ball.position, ball.velocity, ball.acceleration
    return (
        p[0] + dt * (v[0] + half * a[0]),
        p[1] + dt * (v[1] + half * a[1]),
        p[2] + dt * (v[2] + half * a[2]),
    )


@inner
def touches_another(s: Simulation, index: int, besides: int, time: float, reach: float) -> bool:
    """Whether a ball is within reach of any other one, besides one."""
    x, y, z = position_at(s.balls[index], time)
    for i in range(len(s.balls)):
        if i in (index, besides) or s.balls[i].motion > FLIGHT:
            continue
        p, q, r = position_at(s.balls[i], time)
        p, q, r = x - p, y - q, z - r
        if p * p + q * q + r * r <= reach * reach:
            return True
    return False


@innermost
def is_translating(ball: BallRecord) -> bool:
    """Whether a ball's centre moves."""
    motion = ball.motion
    return motion != REST and motion != SPIN and motion <= FLIGHT


@inner
def predict_boundary_event(table: TableModel, s: Simulation, ball: BallRecord) -> None:
    """Find when a ball, in its present segment, meets something of the table."""
    if table.numbers.endless or not is_translating(ball):
        ball.boundary_time, ball.boundary_feature = math.inf, NOTHING
    elif ball.motion == FLIGHT and ball.acceleration[2] != 0.0:
        ball.boundary_time, ball.boundary_feature = next_flight_boundary(table, ball)
    else:
        ball.boundary_time, ball.boundary_feature, searched = next_rolling_boundary(table, ball)
        s.progress.searches += searched


@inner
def meeting_time(ball: BallRecord, cue: BallRecord, reach: float) -> float:
    """
    When a cue meets a ball in the ball's present segment [s], or inf.

    If they meet at once, the ball has not been clear of the cue yet: it holds the cue's end aside,
    and that is no hit. But it is one if the ball comes back from a cushion that it pressed.

    Parameters
    ----------
    ball : BallRecord
    cue : BallRecord
        The sphere of the tip, until its `end`.
    reach : float
        Distance of the centres of tip and ball as they meet [m].

    """
    end = min(ball.end, cue.end)
    if ball.time >= end:
        return math.inf
    time = collision_time(cue, ball, ball.time, end, reach)
    comes_back = ball.cause == RELEASE and ball.time > cue.time  # and not from a hit
    return time if time > ball.time or comes_back else math.inf


@inner
def predict_cue(table: TableModel, s: Simulation, ball: BallRecord) -> None:
    """
    Find when the cue that follows its stroke meets the ball that it struck, in its segment.

    During a hit nothing is to be found: the time of the cue is the end of the hit.
    """
    cue, meets = s.cue, ball.motion <= FLIGHT and s.cue.time <= ball.time
    cue.meeting_time = meeting_time(ball, cue, table.cue.reach) if meets else math.inf


@inner
def note_meeting(s: Simulation, i: int, j: int, time: float) -> None:
    """Note when ball 0 meets another ball first, if it is ball i < j."""
    if i == 0 and s.balls[j].met_time == math.inf:
        s.balls[j].met_time, s.balls[j].met_after = time, s.balls[0].cushions


@inner
def share_impact(a: BallRecord, b: BallRecord) -> bool:
    """Whether an impact that lasts knows how both balls move: they take part in it, or rest."""
    one, other = a.nose == IMPACT, b.nose == IMPACT
    if not (one or other) or a.impact != b.impact:
        return False
    return (one or not is_translating(a)) and (other or not is_translating(b))


@inner
def find_next_meeting(s: Simulation, index: int) -> None:
    """Find which of the balls after it a ball meets next; of equal times, the first ball."""
    ball, row = s.balls[index], s.collisions[index]
    ball.meeting_time, ball.meets = math.inf, NOTHING
    for i in range(index + 1, len(s.balls)):
        if row[i] < ball.meeting_time:
            ball.meeting_time, ball.meets = row[i], i


@inner
def note_collision(s: Simulation, i: int, j: int, time: float) -> None:
    """Note when balls i < j meet, and what this changes of the next meeting of ball i."""
    ball = s.balls[i]
    s.collisions[i][j] = time
    if time < ball.meeting_time or (time == ball.meeting_time and j < ball.meets):
        ball.meeting_time, ball.meets = time, j
    elif j == ball.meets:
        find_next_meeting(s, i)


@inner
def predict_collisions(table: TableModel, s: Simulation, index: int, now: float) -> None:
    """
    Find when a ball meets each other one, before either does something else anyway.

    GATE_ON as `pair_gate` looks at every pair, and to the end of its segments; GATE_OFF at none.
    """
    gate, diameter = table.numbers.pair_gate, 2.0 * table.params.radius
    if gate == GATE_OFF:
        return
    ball = s.balls[index]
    until = ball.end
    if gate != GATE_ON:
        until = min(until, ball.boundary_time)
    on_table = ball.motion <= FLIGHT
    any_other = gate == GATE_ON or is_translating(ball)
    for i in range(len(s.balls)):
        if i == index:
            continue
        other = s.balls[i]
        time = math.inf
        may_meet = on_table and other.motion <= FLIGHT and not share_impact(ball, other)
        if may_meet and (any_other or is_translating(other)):
            end = other.end if other.end < until else until
            if gate != GATE_ON and other.boundary_time < end:
                end = other.boundary_time
            s.progress.searches += 1
            time = collision_time(ball, other, now, end, diameter)
        if index < i:
            s.collisions[index][i] = time
        else:
            note_collision(s, i, index, time)
    find_next_meeting(s, index)
