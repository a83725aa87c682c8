"""A strike: whether its stroke can be played, and what the impact of cue, ball and cloth does."""

from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.impact.beginning import ContactProperties
from billiard_shot.impact.outcome import CollisionOutcome, ContactResult
from billiard_shot.impact.state import BALL_BODY, BodyState, PLANE
from billiard_shot.numerics.vectors import dot, unit
from billiard_shot.records import Floats, Storage, Vector
from billiard_shot.shot.accuracy import drift_of, strike_tolerance
from billiard_shot.shot.clearance import clearance, NOTHING_AROUND, Surroundings
from billiard_shot.shot.model import StrikeModel
from billiard_shot.status import (
    CUE_THROUGH_CLOTH,
    INVALID_STROKE,
    MISS,
    NEGATIVE_ELEVATION,
    OK,
)
from billiard_shot.table.cue import CueParams, CueRecord, NO_CUE
from billiard_shot.table.cue_impact import (
    CLOTH_CONTACT,
    note_strike,
    set_tip_and_cloth,
    TIP_CONTACT,
    write_contact,
    write_fixed,
    write_tip,
)
from billiard_shot.table.params import BallClothParams, GATE_AUTO
from billiard_shot.table.run import EventLog

GRAZING = 1e-12  # cosine of the angle between stroke and normal below which nothing is hit
LEVEL = 1e-9  # rad, elevation that a level stroke may have by rounding
ROUNDED = 1e-9  # of the tip's height: so deep in the cloth a cue may be by rounding
BODIES, CONTACTS = 3, 2  # of a strike: ball, tip and cloth; TIP_CONTACT and CLOTH_CONTACT
PHASE_ROOM = 16  # of a strike that is recorded: room at first, most have fewer
IMPACT_TOLERANCE = 1e-9  # of later impacts with the cue, relative to their largest approach speeds


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

    cues: list[CueRecord]  # n
    bodies: list[BodyState]  # n BODIES; their origin is the centre of the ball
    contacts: list[ContactProperties]  # n CONTACTS
    accuracy: Floats  # (n,) tolerance of the impact; 0 for a stroke that is refused
    scratch: Floats  # (4, 3)


def work_for(storage: Storage, n: int) -> StrikeWork:
    """Make room for n strikes."""
    return StrikeWork(
        storage.records(CueRecord, n),
        storage.records(BodyState, BODIES * n),
        storage.records(ContactProperties, CONTACTS * n),
        storage.zeros(n),
        storage.zeros(4, 3),
    )


def _prepare_example(storage: Storage) -> tuple[Any, ...]:
    ones = storage.array(np.ones((1, 3)))
    strokes = Strokes(EXAMPLE_MODEL, ones, ones, ones[0]).stored(storage)
    return strokes, NO_CUE, work_for(storage, 1), 1.0


@entry(_prepare_example)
def prepare_strikes(strokes: Strokes, q: CueParams, work: StrikeWork, tolerance: float) -> None:
    """
    State strokes as collisions of ball, tip and cloth, for a tolerance [m] of the trajectories.

    Of the cues, tip, axis, speed and status are set; of those that are refused only the status.
    """
    model = strokes.model
    ball_response = 1.0 / model.surface.mass
    turning = model.surface.radius * model.surface.radius / model.surface.inertia
    for i in range(len(work.cues)):
        cue = work.cues[i]
        ball, tip = work.bodies[BODIES * i], work.bodies[BODIES * i + 1]
        n, c = work.scratch[3], cue.axis
        speed = unit(strokes.velocities[i], c)
        unit(strokes.normals[i], n)
        cue.status = refusal(model, strokes.around, n, c, strokes.position)
        work.accuracy[i] = 0.0
        if cue.status != OK:
            for k in range(3):
                c[k] = 0.0
            continue
        work.accuracy[i] = strike_tolerance(model, speed, tolerance)
        cue.speed, cue.tolerance = speed, IMPACT_TOLERANCE
        cue.drift = drift_of(work.accuracy[i], speed)
        upper, lower = (
            work.contacts[CONTACTS * i + TIP_CONTACT],
            work.contacts[CONTACTS * i + CLOTH_CONTACT],
        )
        write_contact(upper, 1, 0, 0.0)
        write_contact(lower, 0, 2, 0.0)
        set_tip_and_cloth(q, c, n, upper, lower, work.scratch)
        write_tip(q, c, speed, tip)
        cloth = work.bodies[BODIES * i + 2]
        write_fixed(cloth, PLANE, 0.0, 0.0, 1.0)
        cloth.position[2] = -model.surface.radius
        for k in range(3):
            tip.position[k] = q.reach * n[k]
            cue.tip[k] = strokes.position[k] + tip.position[k]
        write_fixed(ball, BALL_BODY, 0.0, 0.0, 0.0)
        ball.response = ball.across = ball_response
        ball.turning = turning


def _finish_example(storage: Storage) -> tuple[Any, ...]:
    return (
        work_for(storage, 1),
        1.0,
        True,
        True,
        storage.records(ContactResult, CONTACTS),
        storage.records(CollisionOutcome, 1),
    )


@entry(_finish_example)
def finish_strikes(
    work: StrikeWork,
    radius: float,
    follows: bool,
    repeats: bool,
    results: list[ContactResult],
    outcomes: list[CollisionOutcome],
) -> None:
    """
    Complete n strikes after their impacts were solved.

    Parameters
    ----------
    work : StrikeWork
        As `prepare_strikes` left it, with the bodies after the impacts.
    radius : float
        Of the ball [m].
    follows : bool
        Whether the cues go on after their strikes.
    repeats : bool
        Whether a strike in which tip or cloth meet the ball again counts their hits; else it is
        one hit.
    results, outcomes : n CONTACTS ContactResult, n CollisionOutcome
        Of the impacts.

    """
    for i in range(len(work.cues)):
        if work.accuracy[i] > 0.0:
            cue, ball, tip = work.cues[i], work.bodies[BODIES * i], work.bodies[BODIES * i + 1]
            upper, lower = (
                results[CONTACTS * i + TIP_CONTACT],
                results[CONTACTS * i + CLOTH_CONTACT],
            )
            note_strike(cue, follows, outcomes[i], upper, lower, upper.final_slip, body=tip)
            cue.hits = max(upper.closings, lower.closings) if repeats else 1
            for k in range(3):
                cue.velocity[k], cue.spin[k] = ball.velocity[k], ball.spin[k] / radius


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

    params: CueParams
    cues: NDArray[np.void]  # (n,) CueRecord
    starts: NDArray[np.void]  # (n, balls) BallStart: the balls afterwards
    # Of the last strike, if it is recorded: PhaseLog (phases, N) of its N contacts, their losses
    # (N, 2) [J], and the meetings of balls.
    log: NDArray[np.void]
    losses: NDArray[np.float64]
    events: EventLog
