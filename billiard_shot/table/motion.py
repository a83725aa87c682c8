"""
The kinds of motion, each at constant acceleration, and the records of balls and segments.

A segment holds from its time on, until the next segment of the ball begins:
    position = p + v dt + a dt^2 / 2 ,   velocity = v + a dt ,   spin = w + w' dt .
"""

from enum import IntEnum
import math

from billiard_shot.compiled import inner, innermost
from billiard_shot.records import record, Vector, Vector3


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


@record
class BallRecord:
    """A ball in its present segment, and what happens to it next."""

    time: float  # s; this and the next eight fields are those of its segment
    position: Vector3
    velocity: Vector3
    acceleration: Vector3
    spin: Vector3
    spin_acceleration: Vector3
    motion: int
    cause: int
    ball: int
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
    boundary_feature: int  # what that is, see rolling_boundary.py
    meeting_time: float  # s, when it meets a ball with a higher index, or inf
    meets: int  # which one, or NOTHING
    pocket: int  # in which the ball lies, or NOTHING
    first_contact: int  # the first ball that it met, or NOTHING
    cushions: int  # impacts with straight cushions so far
    jaws: int  # impacts with rounded jaws before it met another ball
    left_out: float  # m, bound of the error by hops that were left out before that
    last_edge: float  # s, when it last met a cushion or a jaw, or -inf
    met_time: float  # s, when ball 0 met it first, or inf
    met_after: int  # straight cushions that ball 0 had met before that
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
