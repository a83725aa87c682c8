"""A stroke: whether it can be played, what the impact does, and what follows on endless cloth."""

from math import inf, sqrt
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.impact.outcome import CollisionOutcome, ContactResult
from billiard_shot.impact.state import PhaseLog
from billiard_shot.numerics.vectors import dot, unit
from billiard_shot.records import Floats, record, ROWS, Storage, Vector, Vector3
from billiard_shot.shot.accuracy import HOPS, strike_tolerance, trajectory_error
from billiard_shot.shot.clearance import clearance, NOTHING_AROUND, Surroundings
from billiard_shot.shot.contacts import (
    approach_velocity,
    contact_jacobians,
    delassus_operator,
    tip_response,
    weighted,
)
from billiard_shot.shot.model import StrikeModel, tip_reach
from billiard_shot.status import (
    CUE_THROUGH_CLOTH,
    INFINITE_SEQUENCE,
    INVALID_STROKE,
    MISCUE,
    MISS,
    NEGATIVE_ELEVATION,
    OK,
    TOLERANCE_NOT_REACHED,
)
from billiard_shot.table.motion import append_segment, Ball, FLIGHT, Segment, start_ball
from billiard_shot.table.params import AUTO, BallClothParams
from billiard_shot.table.roll_out import roll_out

GRAZING = 1e-12  # cosine of the angle between stroke and normal below which nothing is hit
LEVEL = 1e-9  # rad, elevation that a level stroke may have by rounding
ROUNDED = 1e-9  # of the tip's height: so deep in the cloth a cue may be by rounding
# Slip at the end, relative to the cue's speed, that makes a miscue. Grip fades with the tip's
# pressure: while the cloth still pushes the ball, every tip slips in the last instant, in scene
# `pool` by up to 0.02 of the cue's speed. Tips that slide in earnest end with more than 0.06.
MISCUE_SLIP = 0.03
FOLLOW_THROUGH = 0.15  # m, that players let the cue go on after the strike
LONGEST_FOLLOW_THROUGH = 1.0  # s: nobody follows through for longer, however slowly


@record
class Strike:
    """What a stroke does to the cue ball, on endless cloth. Frame `table`."""

    velocity: Vector3  # [m/s] at the end of the strike
    spin: Vector3  # [rad/s]
    final_position: Vector3  # [m]
    cue_speed: float  # [m/s] along the stroke
    duration: float  # [s] from the end of the strike to rest
    error: float  # [m] estimate
    losses: Annotated[Any, 4]  # [J] tip restitution, tip friction; the same of the table
    impulses: Annotated[Any, 6]  # [N s] of tip and table: normal, two tangential
    axes: Annotated[Any, 18]  # of tip and table: normal and two tangents as rows
    discontinuity_margin: float  # see `ContactResult`; the least of tip and table
    tip: Vector3  # [m] from the ball's centre to that of the tip's sphere, at the end
    again: float  # [s] when the cue that follows meets the ball, on endless cloth; or inf
    # How often tip or cloth, whichever did more often, met the ball; or, if a strike was solved
    # with moving normals, the tip.
    hits: int
    status: int  # Status
    phases: int
    steps: int
    segments: int


@inner
def refusal(
    model: StrikeModel, around: Surroundings, n: Vector, c: Vector, position: Vector
) -> int:
    """Why a stroke along c, at the normal n, cannot be played, or OK."""
    cosine = dot(n, c)
    if not -inf < cosine < inf:
        return INVALID_STROKE
    if cosine > -GRAZING:
        return MISS
    if c[2] > LEVEL:
        return NEGATIVE_ELEVATION
    height = model.surface.radius * (1.0 + n[2])
    lowest = height - model.ferrule_radius * sqrt(max(1.0 - c[2] * c[2], 0.0))
    if lowest < -ROUNDED * height:
        return CUE_THROUGH_CLOTH
    return clearance(around, n, c, position)


@inner
def final_status(status: int, miscue: bool, end: int, exact: bool) -> int:
    """Status of a stroke: that of its impact, unless the impact went well."""
    if status != OK and status != INFINITE_SEQUENCE:
        return status
    if miscue:
        return MISCUE
    if end != OK:
        return end
    return status if exact else TOLERANCE_NOT_REACHED


class StrikeTask(NamedTuple):
    """n strokes at a ball that lies in one place."""

    model: StrikeModel
    normals: Floats  # (n, 3) as of `Stroke`, but not checked yet
    velocities: Floats  # (n, 3) m/s
    position: Vector  # (3,) m, centre of the cue ball
    tolerance: float  # m, of the trajectories


class StrikeWork(NamedTuple):
    """The strikes of n strokes while they are computed, and scratch."""

    strikes: list[Strike]  # n
    jacobians: Floats  # (n, 3, 6, 3) see contacts.py, like the next two
    delassus: Floats  # (n, 6, 6)
    approach: Floats  # (n, 6)
    accuracy: Floats  # (n,) tolerance of the impact; 0 for a stroke that is refused
    balls: list[Ball]  # 2, scratch
    vectors: Floats  # (3, 3) scratch; the last row is the vertical


def work_for(storage: Storage, n: int) -> StrikeWork:
    """Make room for n strikes."""
    zeros = storage.zeros
    return StrikeWork(
        storage.records(Strike, n),
        zeros(n, 3, 6, 3),
        zeros(n, 6, 6),
        zeros(n, 6),
        zeros(n),
        storage.records(Ball, 2),
        storage.array(np.eye(3)),
    )


def _prepare_example(storage: Storage) -> tuple[Any, ...]:
    ones = storage.array(np.ones((1, 3)))
    task = StrikeTask(_MODEL, ones, ones, ones[0], 1.0)
    return task, work_for(storage, 1), stored(storage, NOTHING_AROUND)


@entry(_prepare_example)
def prepare_strikes(task: StrikeTask, work: StrikeWork, around: Surroundings) -> None:
    """
    State n strokes, whose cues need room among others, as collisions in contact space.

    Of the strikes only the status is set.
    """
    n, c, z = work.vectors[0], work.vectors[1], work.vectors[2]
    for i in range(len(work.strikes)):
        work.accuracy[i] = 0.0
        speed = unit(task.velocities[i], c)
        unit(task.normals[i], n)
        status = refusal(task.model, around, n, c, task.position)
        work.strikes[i].status = status
        if status == OK:
            jacobians = work.jacobians[i]
            work.accuracy[i] = strike_tolerance(task.model, speed, task.tolerance)
            contact_jacobians(task.model.surface.radius, n, c, z, jacobians)
            delassus_operator(task.model, c, jacobians, work.delassus[i])
            approach_velocity(jacobians, speed, n, c, work.approach[i])


def _finish_example(storage: Storage) -> tuple[Any, ...]:
    return (
        *_prepare_example(storage)[:2],
        storage.records(ContactResult, 2),
        storage.records(CollisionOutcome, 1),
        storage.records(Segment, 1),
    )


@entry(_finish_example)
def finish_strikes(
    task: StrikeTask,
    work: StrikeWork,
    results: list[ContactResult],
    outcomes: list[CollisionOutcome],
    segments: list[Segment],
) -> None:
    """
    Complete n strikes after their impacts were solved, and roll the balls out on endless cloth.

    Parameters
    ----------
    task, work : StrikeTask, StrikeWork
        As `prepare_strikes` left them.
    results, outcomes : 2 n ContactResult, n CollisionOutcome
        Of the impacts.
    segments : records of Segment, written
        The last trajectory, as many segments as there is room for.

    """
    model, position, tolerance = task.model, task.position, task.tolerance
    ball, follower, c, cue = work.balls[0], work.balls[1], work.vectors[0], work.vectors[1]
    reach = tip_reach(model)
    follower.motion = FLIGHT  # its height counts
    for i in range(len(work.strikes)):
        strike = work.strikes[i]
        if work.accuracy[i] > 0.0:
            outcome, tip, table = outcomes[i], results[2 * i], results[2 * i + 1]
            speed = unit(task.velocities[i], c)
            write_strike(model, strike, work.jacobians[i], tip, table)
            weighted(strike.impulses, work.jacobians[i][0], cue)
            strike.cue_speed = speed + tip_response(model, c, cue, c)
            strike.phases, strike.steps = outcome.phases, outcome.steps
            start_ball(ball, position, strike.velocity, strike.spin)
            strike.hits = max(tip.closings, table.closings)
            for k in range(3):
                strike.tip[k] = reach * strike.axes[k]
                follower.position[k] = position[k] + strike.tip[k]
                follower.velocity[k] = strike.cue_speed * c[k]
            follower.end = follow_through_time(strike.cue_speed) if model.follows else 0.0
            ending, left_out, strike.again = roll_out(
                model.surface, ball, HOPS * tolerance, segments, follower, reach
            )
            strike.error = left_out + trajectory_error(work.accuracy[i], speed, ball.time)
            miscue = tip.final_slip > MISCUE_SLIP * speed
            exact = strike.error <= tolerance
            strike.status = final_status(outcome.status, miscue, ending, exact)
        else:
            for k in range(3):
                cue[k] = 0.0
            start_ball(ball, position, cue, cue)
            append_segment(ball, segments)
            strike.again, strike.hits = inf, 0
        for k in range(3):
            strike.final_position[k] = ball.position[k]
        strike.duration, strike.segments = ball.time, ball.segments


@inner
def follow_through_time(speed: float) -> float:
    """For how long a cue with a speed [m/s] goes on after its stroke, or recoils [s]."""
    return FOLLOW_THROUGH / max(abs(speed), FOLLOW_THROUGH / LONGEST_FOLLOW_THROUGH)


@inner
def write_strike(
    model: StrikeModel,
    strike: Strike,
    jacobians: Floats,
    tip: ContactResult,
    table: ContactResult,
) -> None:
    """Write what follows from the impulses of a strike."""
    ball = model.surface
    impulses, losses = strike.impulses, strike.losses
    impulses[0], impulses[1], impulses[2] = tip.impulse, tip.impulse_1, tip.impulse_2
    impulses[3], impulses[4], impulses[5] = table.impulse, table.impulse_1, table.impulse_2
    losses[0], losses[1] = tip.restitution_loss, tip.friction_loss
    losses[2], losses[3] = table.restitution_loss, table.friction_loss
    strike.discontinuity_margin = min(tip.discontinuity_margin, table.discontinuity_margin)
    weighted(impulses, jacobians[1], strike.velocity)
    weighted(impulses, jacobians[2], strike.spin)
    for k in range(3):
        strike.velocity[k] /= ball.mass
        strike.spin[k] /= ball.inertia
    for k in range(9):
        strike.axes[k] = jacobians[0][k // 3][k % 3]
        strike.axes[9 + k] = jacobians[1][3 + k // 3][k % 3]


_MODEL = StrikeModel(
    cue_mass=1.0,
    inverse_end_mass=1.0,
    ferrule_radius=0.0,
    tip_curvature=1.0,
    friction=(1.0, 1.0),
    restitution=(1.0, 1.0),
    stiffness=(1.0, 1.0),
    law=0,
    exponent=1.0,
    table=True,
    follows=True,
    surface=BallClothParams(*(1.0,) * 10, law=0, exponent=1.0, flight_gate=AUTO),
)  # for the examples; of no ball in particular


class Strikes(NamedTuple):
    """Strokes that were played on endless cloth."""

    strikes: NDArray[np.void]  # (n,) Strike
    log: NDArray[np.void]  # (phases, 2) PhaseLog of the last impact
    segments: NDArray[np.void]  # (segments,) Segment of the last trajectory


def no_phases() -> NDArray[np.void]:
    """Return an empty log (0, 2) of `PhaseLog`."""
    return ROWS.records(PhaseLog, 0).reshape(-1, 2)


def stored(storage: Storage, around: Surroundings) -> Surroundings:
    """Return surroundings whose balls live in a storage."""
    return around._replace(balls=storage.array(around.balls))
