"""Strokes: whether they can be played, and the cues with which runs of the table begin."""

from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.numerics.vectors import dot, unit
from billiard_shot.records import Array, as_rows, Floats, Storage, Vector
from billiard_shot.shot.accuracy import drift_of, strike_tolerance
from billiard_shot.shot.clearance import clearance, NOTHING_AROUND, Surroundings
from billiard_shot.shot.model import StrikeModel, tip_reach
from billiard_shot.status import (
    CUE_THROUGH_CLOTH,
    INVALID_STROKE,
    MISS,
    NEGATIVE_ELEVATION,
    OK,
)
from billiard_shot.table.cue import CueRecord
from billiard_shot.table.model import ENDLESS
from billiard_shot.table.params import BallClothParams, GATE_AUTO, TableParams

GRAZING = 1e-12  # cosine of the angle between stroke and normal below which nothing is hit
LEVEL = 1e-9  # rad, elevation that a level stroke may have by rounding
ROUNDED = 1e-9  # of the tip's height: so deep in the cloth a cue may be by rounding


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
    follow_through=1.0,
    surface=BallClothParams(*(1.0,) * 10, law=0, exponent=1.0, flight_gate=GATE_AUTO),
)  # for the examples; of no ball in particular


class Strokes(NamedTuple):
    """n strokes at a ball in one place among the same others."""

    model: StrikeModel
    normals: Array  # (n, 3) as of `Stroke`, but not checked yet
    velocities: Array  # (n, 3) m/s
    position: Array  # (3,) m, centre of the cue ball
    around: Surroundings = NOTHING_AROUND  # a cue that has no room among them is refused
    table: TableParams = ENDLESS
    others: Array = np.zeros((0, 3))  # (balls, 3) m, centres of the other balls

    def some(self, which: slice | NDArray[np.integer]) -> 'Strokes':
        """Return some of the strokes."""
        return self._replace(normals=self.normals[which], velocities=self.velocities[which])


def _example(storage: Storage) -> tuple[Any, ...]:
    ones = storage.array(np.ones((1, 3)))
    around = NOTHING_AROUND.stored(storage)
    return EXAMPLE_MODEL, around, ones[0], ones, ones, 1.0, 1.0, storage.records(CueRecord, 1)


@entry(_example)
def place_cues(
    model: StrikeModel,
    around: Surroundings,
    place: Floats,
    normals: Floats,
    velocities: Floats,
    tolerance: float,
    reaching_speed: float,
    cues: list[CueRecord],
) -> None:
    """
    Put a cue at the ball for each of n strokes.

    Parameters
    ----------
    model, around, place, normals, velocities
        See `Strokes`.
    tolerance : float
        Of the trajectories [m].
    reaching_speed : float
        Of a cue [m/s] from which on the ball may reach others, or a cushion, in the strike.
    cues : n CueRecord
        Written; of those that are refused only the status.

    """
    reach = tip_reach(model)
    for i in range(len(cues)):
        cue = cues[i]
        speed = unit(velocities[i], cue.axis)
        unit(normals[i], cue.normal)
        cue.status = refusal(model, around, cue.normal, cue.axis, place)
        if cue.status != OK:
            for k in range(3):
                cue.axis[k] = cue.normal[k] = 0.0
            continue
        cue.speed, cue.strikes, cue.others = speed, True, speed >= reaching_speed
        cue.tolerance = strike_tolerance(model, speed, tolerance)
        cue.drift = drift_of(cue.tolerance, speed)
        for k in range(3):
            cue.tip[k] = place[k] + reach * cue.normal[k]


def cues_of(
    strokes: Strokes, tolerance: float = 1.0, reaching_speed: float = inf
) -> NDArray[np.void]:
    """
    Put a cue at the ball for each stroke; parameters as of `place_cues`.

    Returns (n,) CueRecord. If a normal or a velocity is zero or not finite, the status of its
    stroke is INVALID_STROKE.
    """
    run = place_cues.current()
    storage, array = run.storage, run.storage.array
    cues = storage.records(CueRecord, len(strokes.normals))
    run(
        strokes.model,
        strokes.around.stored(storage),
        array(strokes.position),
        array(strokes.normals),
        array(strokes.velocities),
        tolerance,
        reaching_speed,
        cues,
    )
    return as_rows(CueRecord, cues)
