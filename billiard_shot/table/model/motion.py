"""The kinds of motion, each at constant acceleration; records of balls and of a simulation."""

from enum import IntEnum
import math
from typing import Annotated, Any, NamedTuple

from billiard_shot.compiled import inner, innermost
from billiard_shot.records import record, Storage, Vector, Vector3
from billiard_shot.table.model.geometry import BallClothParams


class Motion(IntEnum):
    """What a ball is doing; the numbers are those of billiard_shot_msgs/msg/BallTrajectory."""

    REST = 0
    SLIDE = 1  # on the cloth, its lowest point slips
    ROLL = 2  # on the cloth, without slip
    SPIN = 3  # turns in place about the vertical
    FLIGHT = 4
    POCKETED = 5  # lies in a pocket
    OFF_TABLE = 6  # left the table, where it was last seen
    ABSENT = 7  # is not on this table of a batch: no trajectory has it


class Cause(IntEnum):
    """What began a segment. Names of members are values of `EventKind`, but for four."""

    START = 0
    OWN = 1  # the segment before it was over: the ball stopped slipping, landed ...
    BALL = 2
    CUSHION = 3
    CLUSTER = 4  # an impact of more than two bodies
    POCKET = 5
    OFF = 6
    RELEASE = 7  # a contact that took time is over: with a cushion, or with several balls
    CUE = 8  # the cue, which follows its stroke, hits the ball again
    ROLL_ON = 9  # no event: a rolling ball goes on with another deceleration, see rolling.py


REST, SLIDE, ROLL, SPIN, FLIGHT, POCKETED, LEFT_TABLE, ABSENT = map(int, Motion)
START, OWN, BALL, CUSHION, CLUSTER, POCKET, WENT_OFF, RELEASE, CUE, ROLL_ON = map(int, Cause)

NOTHING = -1  # index of a ball, pocket or feature that does not exist
# In place of the nose that a ball presses: it takes part in an impact of several balls.
IMPACT = -2

# A ball within this distance of a nose is frozen to it [m]: the next contact with that nose counts
# only if the ball has left the nose by more than this (WPA 8.4, driven to a rail).
FROZEN = 1e-3


@record
class SegmentRecord:
    """A stretch of one kind of motion, from its start on."""

    time: float  # s
    position: Vector3  # m, of the centre
    velocity: Vector3  # m/s
    acceleration: Vector3  # m/s^2
    spin: Vector3  # rad/s
    spin_acceleration: Vector3  # rad/s^2
    motion: int  # Motion
    cause: int  # Cause
    ball: int  # index


class BallLog:
    """Balls, cushions and pocket that a ball has met until now: fields of its records."""

    pocket: int  # in which it lies, or NOTHING
    first_contact: int  # the first ball that it met, or NOTHING
    cushions: int  # impacts with straight cushions
    left_out: float  # m, bound of the error by hops that were left out before it met another ball
    last_edge: float  # s, when it was last driven to a cushion or a jaw, or -inf
    met_time: float  # s, when ball 0 met it first, or inf
    met_after: int  # straight cushions that ball 0 had met before that


@record
class BallRecord(SegmentRecord, BallLog):
    """A ball in its present segment, and what happens to it next."""

    end: float  # s, when the segment ends
    spin_ends: bool  # the segment ends because the spin about the vertical is used up
    # Of a roll in two halves, see rolling.py: decelerations [m/s^2], and when they end [s].
    roll_first: float
    roll_turn: float
    roll_then: float
    roll_until: float  # inf: with the ball at rest
    landing_speed: float  # m/s, with which it comes down after lumped bounces (flight.py), or 0
    bounces: int  # since the last impact with anything but the cloth
    boundary_time: float  # s, when the ball meets something of the table, or inf
    boundary_feature: int  # what that is, see table/motion/boundaries.py
    meeting_time: float  # s, when it meets a ball with a higher index, or inf
    meets: int  # which one, or NOTHING
    jaws: int  # impacts with rounded jaws before it met another ball
    modified: bool  # by an impact of several bodies: its next segment has to begin
    # Number of the event of such an impact that knows how the ball moves in this segment; NOTHING.
    impact: int
    # The cushion that the ball presses in this segment, or IMPACT, or NOTHING. At the end of the
    # segment it gets its exit velocity and spin.
    nose: int
    exit_velocity: Vector3
    exit_spin: Vector3


@inner
def start_ball(ball: BallRecord, position: Vector, velocity: Vector, spin: Vector) -> None:
    """Put a ball into a state at time 0."""
    for i in range(3):
        ball.position[i], ball.velocity[i], ball.spin[i] = position[i], velocity[i], spin[i]
        ball.acceleration[i], ball.spin_acceleration[i] = 0.0, 0.0
    ball.time, ball.end, ball.boundary_time, ball.landing_speed = 0.0, 0.0, math.inf, 0.0
    ball.motion, ball.cause, ball.ball = REST, START, 0
    ball.bounces, ball.cushions, ball.jaws, ball.left_out = 0, 0, 0, 0.0
    ball.boundary_feature, ball.pocket, ball.first_contact = NOTHING, NOTHING, NOTHING
    ball.meeting_time, ball.meets = math.inf, NOTHING
    ball.last_edge, ball.met_time, ball.met_after = -math.inf, math.inf, 0
    ball.spin_ends, ball.modified = False, False
    ball.roll_first, ball.roll_then = 0.0, 0.0
    ball.roll_turn, ball.roll_until = -math.inf, math.inf
    ball.nose, ball.impact = NOTHING, NOTHING


@inner
def write_segment(ball: BallRecord, segment: SegmentRecord) -> None:
    """Write a ball's present motion into a segment."""
    segment.time, segment.ball = ball.time, ball.ball
    segment.motion, segment.cause = ball.motion, ball.cause
    for i in range(3):
        segment.position[i] = ball.position[i]
        segment.velocity[i] = ball.velocity[i]
        segment.acceleration[i] = ball.acceleration[i]
        segment.spin[i] = ball.spin[i]
        segment.spin_acceleration[i] = ball.spin_acceleration[i]


@innermost
def advance_ball(ball: BallRecord, time: float) -> None:
    """Move a ball on to a time."""
    dt = time - ball.time
    for i in range(3):
        change = ball.acceleration[i] * dt
        ball.position[i] += (ball.velocity[i] + 0.5 * change) * dt
        ball.velocity[i] += change
        ball.spin[i] += ball.spin_acceleration[i] * dt
    ball.time = time


@inner
def stop_ball(ball: BallRecord, motion: int) -> None:
    """Stop a ball where it is, for good."""
    for i in range(3):
        ball.velocity[i], ball.acceleration[i] = 0.0, 0.0
        ball.spin[i], ball.spin_acceleration[i] = 0.0, 0.0
    ball.motion = motion
    ball.end = math.inf


@record
class TableBall(BallLog):
    """
    A ball of a table at the beginning or at the end of a run.

    At the beginning, `time` and the fields of `BallLog` do not count. An exception is
    `first_contact`: the ball may have met another one before the run.
    """

    position: Vector3  # m
    velocity: Vector3  # m/s
    spin: Vector3  # rad/s
    motion: int  # Motion; at the beginning: ABSENT, or any other one
    time: float  # s, since when it rests or, if it never does, its last motion lasts


@record
class Rebound:
    """A ball that meets a nose."""

    # Compression of the nose, height above the cloth, way along the cushion; velocity; spin;
    # deflection of the tangential spring along the two tangents of `nose_slip` or, while the nose
    # slips beneath it, the direction of that.
    state: Annotated[Any, 11]
    trial: Annotated[Any, 11]
    rates: Annotated[Any, 77]  # of seven stages
    time: float
    held: bool  # the ball lies on the cloth
    press: float  # force on the cloth per force of the nose, where the rates were written last
    compressing: bool
    nose_slips: bool  # or sticks, or begins to slip; always false with a tangential spring
    spring_slips: bool  # the tangential spring's force is at the limit of friction
    cloth_slips: bool
    # The rest is the same during all of the contact.
    sine: float  # of the angle of the nose above the ball's centre
    cosine: float
    turn: float  # m r^2 / I
    restitution: float  # of the nose
    lag: float  # shortest time in which a deflection turns
    tangential_stiffness: float  # relative to that of the nose's normal spring; 0: rigid
    nose_friction: float
    cloth_friction: float
    bounce_restitution: float  # of the cloth, if the ball lands
    bounce_friction: float


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
class TableOutcome:
    """How the simulation of a table ends; counts are those so far, while it goes on."""

    duration: float  # s
    status: int  # Status: of the stroke, of its run or of its accuracy; else of the run
    run_status: int  # Status: of the run alone
    error: float  # m, estimate for the trajectory after a stroke; 0: it is not estimated
    # m: how far the end of the trajectory jumps, see shot/play.py; else 0
    discontinuity: float
    segments: int  # of this table and all before it
    events: int
    searches: int  # contacts looked for
    participants: int  # of impacts of several balls
    double_hit: bool  # the cue hit ball 0 again, in the strike or later; chatter does not count
    cue_touches: int  # without the strike
    unsolved: int  # Status of an impact that was not solved, or OK
    flaw: int  # Status of an impact that was solved, but with a flaw, or OK
    jaws_met: int  # rounded jaws that ball 0 met before another ball


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
    progress: TableOutcome
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
    rebound: list[Rebound]  # 1
    cue: list[BallRecord]  # 1


def room_for_simulation(storage: Storage, balls: int) -> SimulationRoom:
    """Make room for so many balls."""
    return SimulationRoom(
        storage.records(BallRecord, balls),
        storage.zeros(balls, balls),
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
def note_meeting(s: Simulation, i: int, j: int, time: float) -> None:
    """Note when ball 0 meets another ball first, if it is ball i < j."""
    if i == 0 and s.balls[j].met_time == math.inf:
        s.balls[j].met_time, s.balls[j].met_after = time, s.balls[0].cushions
