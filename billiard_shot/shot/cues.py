"""Strokes: whether they can be played, and the cues with which runs of the table begin."""

from math import inf, isfinite, sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.numerics.vectors import dot, unit
from billiard_shot.records import Array, as_rows, Floats, Storage, Vector
from billiard_shot.shot.accuracy import drift_of, strike_tolerance
from billiard_shot.shot.clearance import clearance, NOTHING_AROUND, Surroundings
from billiard_shot.shot.mapped_strike import ALL_SOLVED, Mapped, MOTION, SOLVED, write_motion
from billiard_shot.shot.setting import reaching_speeds, Setting
from billiard_shot.shot.strike_model import StrikeModel, tip_reach
from billiard_shot.status import (
    CUE_THROUGH_CLOTH,
    INVALID_STROKE,
    MISS,
    NEGATIVE_ELEVATION,
    OK,
)
from billiard_shot.table.cue import CueRecord, follow_through_time
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
    *(1.0,) * 4,
    *((1.0, 1.0),) * 3,
    law=0,
    exponent=1.0,
    on_cloth=True,
    follow_through=1.0,
    surface=BallClothParams(*(1.0,) * 10, law=0, exponent=1.0, flight_gate=GATE_AUTO),
)  # for the examples; of no ball in particular


def _example(storage: Storage) -> tuple[Any, ...]:
    array, ones = storage.array, storage.array(np.ones((1, 3)))
    return (
        EXAMPLE_MODEL,
        NOTHING_AROUND.stored(storage),
        array(np.ones((1, 1, 3))),
        array(np.ones(1)),
        ones,
        ones,
        ALL_SOLVED.stored(storage),
        1.0,
        storage.zeros(MOTION),
        storage.records(CueRecord, 1),
    )


@entry(_example)
def place_cues(
    model: StrikeModel,
    around: Surroundings,
    places: Floats,
    reaching: Floats,
    normals: Floats,
    velocities: Floats,
    mapped: Mapped,
    tolerance: float,
    motion: Floats,
    cues: list[CueRecord],
) -> None:
    """
    Put a cue at the ball for each of n strokes.

    Parameters
    ----------
    model : StrikeModel
    around : Surroundings
        Its balls do not count.
    places : (n, balls, 3) floats, or (1, balls, 3) for all strokes alike
        Centres of the balls [m]; NaN: the table does not have it.
    reaching : (n,) or (1,) floats
        Speeds of the cue [m/s], see `reaching_speeds`.
    normals, velocities : (n, 3) floats
        As of `Stroke`, but not checked yet.
    mapped : Mapped
        Of the n strokes, or of one that stands for all. What may reach others is solved.
    tolerance : float
        Of the trajectories [m].
    motion : (MOTION,) floats
        Scratch.
    cues : n CueRecord
        Written; of those that are refused only the status.

    """
    for i in range(len(cues)):
        cue, table = cues[i], i % len(places)
        ball = places[table][0]
        near = Surroundings(
            around.cue_length,
            around.ferrule_radius,
            around.ball_radius,
            around.half_length,
            around.half_width,
            around.nose_height,
            places[table][1:],
        )
        speed = unit(velocities[i], cue.axis)
        unit(normals[i], cue.normal)
        there = isfinite(ball[0])
        cue.status = refusal(model, near, cue.normal, cue.axis, ball) if there else MISS
        if cue.status != OK:
            for k in range(3):
                cue.axis[k] = cue.normal[k] = 0.0
            continue
        for k in range(3):
            cue.tip[k] = ball[k] + tip_reach(model) * cue.normal[k]
        cue.others = speed >= reaching[table]
        cell = mapped.number[i % len(mapped.number)]
        if cell == SOLVED or cue.others:
            cue.speed, cue.strikes = speed, True
            cue.tolerance = strike_tolerance(model, speed, tolerance)
            cue.drift = drift_of(cue.tolerance, speed)
            continue
        write_motion(mapped.strokes[i], mapped, cell, motion)
        for k in range(3):
            cue.velocity[k], cue.spin[k] = motion[k], motion[3 + k]
        cue.speed, cue.hits = motion[6], 1
        cue.end = follow_through_time(model.follow_through, cue.speed)


def cues_of(
    setting: Setting,
    normals: Array,
    velocities: Array,
    starts: NDArray[np.void] | None = None,
    mapped: Mapped = ALL_SOLVED,
    tolerance: float = 1.0,
) -> NDArray[np.void]:
    """
    Put a cue at the ball for each of n strokes; parameters as of `place_cues`.

    Parameters
    ----------
    setting : Setting
    normals, velocities : (n, 3) float arrays
    starts : (n, balls) or (1, balls) array of BallStart, optional
        By default as the setting has them.
    mapped : Mapped
        By default all strikes are to be solved.
    tolerance : float
        Of the trajectories [m].

    Returns
    -------
    (n,) array of CueRecord
        If a normal or a velocity is zero or not finite, the status of its stroke is
        INVALID_STROKE.

    """
    places, reaching = setting.starts['position'], setting.reaching
    if starts is not None:
        places = np.where(starts['absent'][..., np.newaxis], np.nan, starts['position'])
        reaching = reaching_speeds(setting.model, setting.table, places)
    run = place_cues.current()
    storage, array = run.storage, run.storage.array
    cues = storage.records(CueRecord, len(normals))
    run(
        setting.model,
        setting.around.stored(storage),
        array(places),
        array(reaching),
        array(normals),
        array(velocities),
        mapped.stored(storage),
        tolerance,
        storage.zeros(MOTION),
        cues,
    )
    return as_rows(CueRecord, cues)
