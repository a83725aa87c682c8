"""
The launches that explain a shot best, and the path to expect if only its beginning was seen.

Nothing is seen of the spin that the cue gives, and after a few collisions the smallest change of a
launch leads elsewhere. So a search compares the first half second, then longer parts; at each
horizon the best launches, and some drawn around them, go on.

The first samples alone do not tell the spin, and the launch that explains them best may have any
spin. So launches are drawn as likely as they are, and the one in the middle is taken: its path has
the least mean distance from those of the others, relative to usual errors. Spins are drawn as
other strokes of the player had them, and mirrored ones: from the density of Silverman (Density
Estimation, 1986, section 4.3). Each draw is the mean of a launch before its samples count, and is
then fitted to them (Oliver, He and Reynolds, Conditioning permeability fields to pressure data,
5th European Conf. on the Mathematics of Oil Recovery (1996)).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from billiard_shot.calibration.launch import (
    CalibrationModel,
    compare,
    Comparison,
    DIRECTION,
    evaluated,
    FIRST_SCALES,
    Fitted,
    FOLLOW,
    KNOTS,
    MASSE,
    normal_equations,
    PLACES,
    refined,
    SIDE,
    SPEED,
    ways_of,
)
from billiard_shot.calibration.recording import Floats
from billiard_shot.calibration.samples import Samples

STARTS = 24
"""Launches with which a search begins."""

KEPT = 8
"""How many different launches go on to the next horizon."""

DRAWN = 40
"""How many are drawn around them; the `KEPT` best of these are improved, too."""

FIRST_HORIZON, GROWTH = 0.5, 1.7
"""First horizon [s], and the factor from each horizon to the next."""

STEPS = 5
"""Steps of least squares at each horizon."""

FOLLOWS, SIDES = (-0.8, 1.2), (-1.0, 1.0)
"""Between which spins, relative to the speed, the first launches lie."""

SPEED_SIGMA, DIRECTION_SIGMA = 0.02, 0.01
"""Deviations of the first launches, relative and in rad."""

SPREAD = 3.0
"""How many standard deviations around the best launches others are drawn."""

APART = 2e-3
"""Launches whose paths differ by less are alike [m]."""

LAST_ROUNDS = 2
"""How often launches are drawn around the best ones at the last horizon."""

SHORT = 0.5
"""If no more than this was seen [s], the errors of samples are those of the tracker."""

DRAWS = 100
"""How many launches are drawn."""

DRAW_STEPS = 8
"""Steps of least squares for each of them."""

UNLIKELY = 8.0
"""A draw whose cost exceeds the least one by more has not found the samples."""

SPINS = slice(FOLLOW, MASSE + 1)
MIRRORED = np.array([1.0, -1.0, -1.0])


def horizons(last: float) -> Iterator[float]:
    """Yield horizons up to the last one [s]."""
    horizon = FIRST_HORIZON
    while horizon < last / GROWTH**0.5:
        yield horizon
        horizon *= GROWTH
    yield last


def search_launches(
    model: CalibrationModel,
    samples: Samples,
    scales: Floats,
    horizon: float,
    draw: np.random.Generator,
    known: Floats | None = None,
) -> Fitted:
    """
    Search the launches of a shot.

    Parameters
    ----------
    model : CalibrationModel
    samples : Samples
    scales : (knots,) float array
        Of errors [m], see `compare`.
    horizon : float
        Until which samples count [s].
    draw : numpy.random.Generator
    known : (n, numbers) float array, optional
        Launches that may be near the best one.

    Returns
    -------
    Fitted
        The best launches first, all different; none if none can be simulated.

    """
    last = min(horizon, samples.duration)
    launches = _starts(compare(samples, scales), draw)
    for until in horizons(last):
        compared = compare(samples, scales, until)
        if known is not None:
            launches = np.concatenate([known, launches])
        best = _distinct(refined(model, compared, launches, STEPS))
        launches = _drawn_around(model, compared, best, draw)
    for _ in range(LAST_ROUNDS):
        best = _distinct(refined(model, compared, launches, STEPS))
        launches = _drawn_around(model, compared, best, draw)
    return best


def _starts(compared: Comparison, draw: np.random.Generator) -> Floats:
    """Draw launches with all spins; if the stroke was commanded, take that without errors."""
    if compared.samples.command is not None:
        return compared.mean[np.newaxis]
    launches = np.repeat(compared.mean[np.newaxis], STARTS, axis=0)
    speed = compared.mean[SPEED]
    launches[:, FOLLOW] = speed * draw.uniform(*FOLLOWS, STARTS)
    launches[:, SIDE] = speed * draw.uniform(*SIDES, STARTS)
    launches[:, SPEED] *= draw.normal(1.0, SPEED_SIGMA, STARTS)
    launches[:, DIRECTION] += draw.normal(0.0, DIRECTION_SIGMA, STARTS)
    return launches


def _drawn_around(
    model: CalibrationModel, compared: Comparison, best: Fitted, draw: np.random.Generator
) -> Floats:
    """Return the best launches and others around them, more around better ones."""
    if not len(best.costs):
        return _starts(compared, draw)
    if compared.samples.command is not None:
        return best.launches  # the best one is near
    matrix, _ = normal_equations(model, compared, best)
    ranks = 1.0 / np.arange(1, len(best.costs) + 1)
    chosen = draw.choice(len(ranks), DRAWN, p=ranks / ranks.sum())
    # The rows of a matrix of directions, each with the inverse of the root of its curvature.
    curvature, directions = np.linalg.eigh(matrix)
    lengths = SPREAD / np.sqrt(np.maximum(curvature, curvature[:, -1:] * 1e-12))
    free = draw.normal(size=(len(chosen), matrix.shape[-1]))
    moves = np.einsum('nik,nk->ni', directions[chosen], lengths[chosen] * free)
    drawn = evaluated(model, compared, best.launches[chosen] + moves)
    return np.concatenate([best.launches, drawn.launches[np.argsort(drawn.costs)[:KEPT]]])


def _distinct(fitted: Fitted) -> Fitted:
    """Return the best launches whose paths differ, the best one first."""
    chosen: list[int] = []
    for k in np.argsort(fitted.costs, kind='stable').tolist():
        if not np.isfinite(fitted.costs[k]) or len(chosen) == KEPT:
            break
        apart = np.abs(fitted.places[chosen] - fitted.places[k]).max(axis=(1, 2), initial=0.0)
        if (apart > APART).all():
            chosen.append(k)
    return fitted.take(np.array(chosen, np.int64))


def spins_of(launches: Sequence[Floats]) -> Floats:
    """Return follow, side and masse (n, 3) relative to the speed, of launches (numbers,)."""
    strikes = np.reshape([each[:PLACES] for each in launches], (-1, PLACES))
    spins: Floats = strikes[:, SPINS] / strikes[:, SPEED, np.newaxis]
    return spins


def middle_launch(
    model: CalibrationModel,
    samples: Samples,
    seen: float,
    spins: Floats,
    draw: np.random.Generator,
) -> Floats | None:
    """
    Return the launch whose path is to be expected; None if none can be simulated.

    Parameters
    ----------
    model : CalibrationModel
    samples : Samples
        Of samples after `seen`, only the times count.
    seen : float
        Until which samples count [s].
    spins : (n, 3) float array
        Of other strokes, see `spins_of`.
    draw : numpy.random.Generator

    """
    compared = compare(samples, FIRST_SCALES, seen)
    speed = compared.mean[SPEED]
    width = spins.std(axis=0) * len(spins) ** (-1.0 / (spins.shape[1] + 4.0))
    width = speed * np.maximum(width, 1e-3)
    means = np.repeat(compared.mean[np.newaxis], DRAWS, axis=0)
    precision = compared.precision.copy()
    mirrored = np.where(draw.random((DRAWS, 1)) < 0.5, 1.0, MIRRORED)
    means[:, SPINS] = speed * mirrored * spins[draw.integers(len(spins), size=DRAWS)]
    means[:, SPINS] += width * draw.normal(size=(DRAWS, len(width)))
    precision[SPINS, SPINS] = np.diag(width**-2.0)
    likely = replace(
        compared,
        mean=means,
        precision=precision,
        square=compared.samples.sigma**2,
        share=np.ones_like(compared.share),
    )
    found = refined(model, likely, means, DRAW_STEPS)
    possible = np.isfinite(found.costs)
    if not possible.any():
        return None
    launches = found.launches[found.costs < found.costs[possible].min() + UNLIKELY]
    places = ways_of(model, samples, launches)
    simulated = np.isfinite(places).all(axis=(1, 2))
    if not simulated.any():
        return None
    launches, places = launches[simulated], places[simulated]
    usual = np.interp(samples.time, KNOTS, FIRST_SCALES)
    apart = [np.linalg.norm(places - each, axis=-1) @ (samples.share / usual) for each in places]
    best: Floats = launches[np.sum(apart, axis=0).argmin()]
    return best
