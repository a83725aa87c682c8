"""A strike: whether its stroke can be played, and what the impact of cue, ball and cloth does."""

from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.impact.kernel import solve_collisions
from billiard_shot.impact.state import BALL_BODY, PLANE
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
from billiard_shot.table.cluster import impact_room, solve_bodies
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
from billiard_shot.table.gather import ImpactRoom
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


def _example(storage: Storage) -> tuple[Any, ...]:
    ones = storage.array(np.ones((1, 3)))
    strokes = Strokes(EXAMPLE_MODEL, ones, ones, ones[0]).stored(storage)
    return (
        strokes,
        NO_CUE,
        1.0,
        impact_room(storage, 1, BODIES, CONTACTS),
        storage.records(CueRecord, 1),
        solve_collisions.as_argument(storage),
    )


@entry(_example)
def strike_balls(
    strokes: Strokes,
    q: CueParams,
    tolerance: float,
    room: ImpactRoom,
    cues: list[CueRecord],
    solver: Any,
) -> None:
    """
    Strike a ball, with nothing near it but the cloth, with each of n strokes.

    Parameters
    ----------
    strokes : Strokes
    q : CueParams
    tolerance : float
        Of the trajectories [m]. 0: strokes are only refused or not.
    room : ImpactRoom
        For BODIES and CONTACTS; afterwards it has the last strike.
    cues : n CueRecord
        Written; of those that are refused only the status.
    solver : function
        `solve_collisions` as an argument.

    """
    model, ball, tip = strokes.model, room.results.bodies[0], room.results.bodies[1]
    radius = model.surface.radius
    upper, lower = room.results.contacts[TIP_CONTACT], room.results.contacts[CLOTH_CONTACT]
    for i in range(len(cues)):
        cue, n = cues[i], room.scratch.workspace.vector[0]
        speed = unit(strokes.velocities[i], cue.axis)
        unit(strokes.normals[i], n)
        cue.status = refusal(model, strokes.around, n, cue.axis, strokes.position)
        if cue.status != OK or tolerance == 0.0:
            for k in range(3):
                cue.axis[k] = 0.0
            continue
        accuracy = strike_tolerance(model, speed, tolerance)
        cue.speed, cue.tolerance = speed, IMPACT_TOLERANCE
        cue.drift = drift_of(accuracy, speed)
        for k in range(3):
            cue.tip[k] = strokes.position[k] + q.reach * n[k]
        write_bodies(model.surface, q, cue, n, room)
        room.tolerance[0] = accuracy
        solve_bodies(model.surface, room, BODIES, CONTACTS, False, inf, solver=solver)
        note_strike(cue, q.follows, room.results.outcomes[0], upper, lower, upper.final_slip, tip)
        repeats = q.follows and q.moves
        cue.hits = max(upper.closings, lower.closings) if repeats else 1
        for k in range(3):
            cue.velocity[k], cue.spin[k] = ball.velocity[k], ball.spin[k] / radius


@inner
def write_bodies(
    surface: BallClothParams, q: CueParams, cue: CueRecord, n: Vector, room: ImpactRoom
) -> None:
    """Write ball, tip and cloth as a stroke meets the ball at n; the origin is its centre."""
    ball, tip, cloth = room.bodies[0], room.bodies[1], room.bodies[2]
    write_contact(room.properties[TIP_CONTACT], 1, 0, 0.0)
    write_contact(room.properties[CLOTH_CONTACT], 0, 2, 0.0)
    set_tip_and_cloth(
        q,
        cue.axis,
        n,
        room.properties[TIP_CONTACT],
        room.properties[CLOTH_CONTACT],
        room.scratch.workspace.polynomials,
    )
    write_tip(q, cue.axis, cue.speed, tip)
    write_fixed(cloth, PLANE, 0.0, 0.0, 1.0)
    cloth.position[2] = -surface.radius
    for k in range(3):
        tip.position[k] = q.reach * n[k]
    write_fixed(ball, BALL_BODY, 0.0, 0.0, 0.0)
    ball.response = ball.across = 1.0 / surface.mass
    ball.turning = surface.radius * surface.radius / surface.inertia


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
