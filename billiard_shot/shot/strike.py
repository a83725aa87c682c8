"""A strike: whether its stroke can be played, and what the impact of cue, ball and cloth does."""

from math import inf, sqrt
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.impact.outcome import CollisionOutcome, ContactResult
from billiard_shot.numerics.vectors import dot, unit
from billiard_shot.records import Floats, record, Storage, Vector, Vector3
from billiard_shot.shot.accuracy import drift_of, strike_tolerance
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
)
from billiard_shot.table.params import BallClothParams, GATE_AUTO
from billiard_shot.table.run import EventLog

GRAZING = 1e-12  # cosine of the angle between stroke and normal below which nothing is hit
LEVEL = 1e-9  # rad, elevation that a level stroke may have by rounding
ROUNDED = 1e-9  # of the tip's height: so deep in the cloth a cue may be by rounding
# Slip at the end, relative to the cue's speed, that makes a miscue. Grip fades with the tip's
# pressure: while the cloth still pushes the ball, every tip slips in the last instant, in scene
# `pool` by up to 0.02 of the cue's speed. Genuine miscues end with more than 0.06.
MISCUE_SLIP = 0.03
PHASE_ROOM = 16  # of a strike that is recorded: room at first, most have fewer


@record
class Strike:
    """What a stroke does to cue and ball, at the end of the strike. Frame `table`."""

    velocity: Vector3  # [m/s]
    spin: Vector3  # [rad/s]
    cue_speed: float  # [m/s] along the stroke
    drift: float  # [m/s] estimate how fast the ball's trajectory departs from the exact one
    losses: Annotated[Any, 4]  # [J] tip restitution, tip friction; the same of the table
    impulses: Annotated[Any, 6]  # [N s] of tip and table: normal, two tangential
    axes: Annotated[Any, 18]  # of tip and table: normal and two tangents as rows
    discontinuity_margin: float  # see `ContactResult`; the least of tip and table
    tip: Vector3  # [m] from the ball's centre to that of the tip's sphere
    hits: int  # how often the tip met the ball
    moving: bool  # whether it was solved with moving bodies, see moving_strikes.py
    together: bool  # whether the ball reached another one or a cushion meanwhile
    status: int  # Status: that of the impact, MISCUE or a refusal
    phases: int
    steps: int


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
def strike_status(status: int, miscue: bool) -> int:
    """Status of a strike: that of its impact, unless it went well and the tip still slides."""
    went_well = status in (OK, INFINITE_SEQUENCE)
    return MISCUE if went_well and miscue else status


class Strokes(NamedTuple):
    """n strokes at a ball that lies in one place. Numbers, or lists of them while interpreted."""

    model: StrikeModel
    normals: Floats  # (n, 3) as of `Stroke`, but not checked yet
    velocities: Floats  # (n, 3) m/s
    position: Floats  # (3,) m, centre of the cue ball
    around: Surroundings = NOTHING_AROUND  # a cue that has no room among them is refused

    def some(self, which: slice | NDArray[np.integer]) -> 'Strokes':
        """Return some of the strokes."""
        return self._replace(normals=self.normals[which], velocities=self.velocities[which])

    def stored(self, storage: Storage) -> 'Strokes':
        """Return the strokes as compiled functions take them."""
        array = storage.array
        return Strokes(
            self.model,
            array(self.normals),
            array(self.velocities),
            array(self.position),
            self.around._replace(balls=array(self.around.balls)),
        )


class StrikeWork(NamedTuple):
    """The strikes of n strokes while they are computed, and scratch."""

    strikes: list[Strike]  # n
    jacobians: Floats  # (n, 3, 6, 3) see contacts.py, like the next two
    delassus: Floats  # (n, 6, 6)
    approach: Floats  # (n, 6)
    accuracy: Floats  # (n,) tolerance of the impact; 0 for a stroke that is refused
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
        storage.array(np.eye(3)),
    )


def _prepare_example(storage: Storage) -> tuple[Any, ...]:
    ones = storage.array(np.ones((1, 3)))
    return Strokes(EXAMPLE_MODEL, ones, ones, ones[0]).stored(storage), work_for(storage, 1), 1.0


@entry(_prepare_example)
def prepare_strikes(strokes: Strokes, work: StrikeWork, tolerance: float) -> None:
    """
    State strokes as collisions in contact space, for a tolerance [m] of the trajectories.

    Of the strikes only the status is set.
    """
    model = strokes.model
    n, c, z = work.vectors[0], work.vectors[1], work.vectors[2]
    for i in range(len(work.strikes)):
        work.accuracy[i] = 0.0
        speed = unit(strokes.velocities[i], c)
        unit(strokes.normals[i], n)
        status = refusal(model, strokes.around, n, c, strokes.position)
        work.strikes[i].status = status
        if status == OK:
            jacobians = work.jacobians[i]
            work.accuracy[i] = strike_tolerance(model, speed, tolerance)
            contact_jacobians(model.surface.radius, n, c, z, jacobians)
            delassus_operator(model, c, jacobians, work.delassus[i])
            approach_velocity(jacobians, speed, n, c, work.approach[i])


def _finish_example(storage: Storage) -> tuple[Any, ...]:
    return (
        *_prepare_example(storage)[:2],
        storage.records(ContactResult, 2),
        storage.records(CollisionOutcome, 1),
    )


@entry(_finish_example)
def finish_strikes(
    strokes: Strokes,
    work: StrikeWork,
    results: list[ContactResult],
    outcomes: list[CollisionOutcome],
) -> None:
    """
    Complete n strikes after their impacts were solved.

    Parameters
    ----------
    strokes, work : Strokes, StrikeWork
        As `prepare_strikes` left them.
    results, outcomes : 2 n ContactResult, n CollisionOutcome
        Of the impacts.

    """
    model, c, cue = strokes.model, work.vectors[0], work.vectors[1]
    reach = tip_reach(model)
    for i in range(len(work.strikes)):
        strike = work.strikes[i]
        if work.accuracy[i] > 0.0:
            outcome, tip, table = outcomes[i], results[2 * i], results[2 * i + 1]
            speed = unit(strokes.velocities[i], c)
            write_strike(model, strike, work.jacobians[i], tip, table)
            weighted(strike.impulses, work.jacobians[i][0], cue)
            strike.cue_speed = speed + tip_response(model, c, cue, c)
            strike.phases, strike.steps = outcome.phases, outcome.steps
            strike.hits = max(tip.closings, table.closings)
            for k in range(3):
                strike.tip[k] = reach * strike.axes[k]
            strike.drift = drift_of(work.accuracy[i], speed)
            miscue = tip.final_slip > MISCUE_SLIP * speed
            strike.status = strike_status(outcome.status, miscue)


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


EXAMPLE_MODEL = StrikeModel(
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
    surface=BallClothParams(*(1.0,) * 10, law=0, exponent=1.0, flight_gate=GATE_AUTO),
)  # for the examples; of no ball in particular


class Strikes(NamedTuple):
    """What n strokes did."""

    rows: NDArray[np.void]  # (n,) Strike
    starts: NDArray[np.void]  # (n, balls) BallStart: the balls afterwards
    # Of the last strike, if it is recorded: PhaseLog (phases, N) of its N contacts; and if it was
    # solved with moving bodies, their losses (N, 2) [J], and the meetings of balls.
    log: NDArray[np.void]
    losses: NDArray[np.float64]
    events: EventLog
