"""Strokes: whether they can be played, and the cues with which runs of the table begin."""

from math import inf, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.numerics.vectors import dot, unit
from billiard_shot.records import as_rows, Floats, Storage, Vector
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
from billiard_shot.table.params import BallClothParams, GATE_AUTO

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
    return strokes, 1.0, 1.0, storage.records(CueRecord, 1)


@entry(_example)
def place_cues(
    strokes: Strokes, tolerance: float, reaching_speed: float, cues: list[CueRecord]
) -> None:
    """
    Put a cue at the ball for each of n strokes.

    Parameters
    ----------
    strokes : Strokes
    tolerance : float
        Of the trajectories [m].
    reaching_speed : float
        Of a cue [m/s] from which on the ball may reach others, or a cushion, in the strike.
    cues : n CueRecord
        Written; of those that are refused only the status.

    """
    model = strokes.model
    reach = tip_reach(model)
    for i in range(len(cues)):
        cue = cues[i]
        speed = unit(strokes.velocities[i], cue.axis)
        unit(strokes.normals[i], cue.normal)
        cue.status = refusal(model, strokes.around, cue.normal, cue.axis, strokes.position)
        if cue.status != OK:
            for k in range(3):
                cue.axis[k] = cue.normal[k] = 0.0
            continue
        cue.speed, cue.strikes, cue.others = speed, True, speed >= reaching_speed
        cue.tolerance = strike_tolerance(model, speed, tolerance)
        cue.drift = drift_of(cue.tolerance, speed)
        for k in range(3):
            cue.tip[k] = strokes.position[k] + reach * cue.normal[k]


def cues_of(strokes: Strokes, tolerance: float, reaching_speed: float) -> NDArray[np.void]:
    """Put a cue at the ball for each stroke; return (n,) CueRecord. See `place_cues`."""
    run = place_cues.current()
    cues = run.storage.records(CueRecord, len(strokes.normals))
    run(strokes.stored(run.storage), tolerance, reaching_speed, cues)
    return as_rows(CueRecord, cues)


def refusals(strokes: Strokes) -> NDArray[np.int64]:
    """Find the status (n,) with which each stroke would be refused, or OK."""
    status: NDArray[np.int64] = cues_of(strokes, 1.0, inf)['status']
    return status
