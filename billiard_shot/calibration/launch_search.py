"""
The launches that explain a shot best: from many starts, with a horizon that grows.

Nothing is seen of the spin that the cue gives, and after a few collisions the smallest change of a
launch leads elsewhere. So a search compares the first half second, then longer parts; at each
horizon the best launches, and some drawn around them, go on.
"""

from collections.abc import Iterator

import numpy as np

from billiard_shot.calibration.comparison import compare, Comparison
from billiard_shot.calibration.launch import DIRECTION, FOLLOW, SIDE, SPEED
from billiard_shot.calibration.recording import Floats, Frame
from billiard_shot.calibration.refine import Fitted, normal_equations, refined
from billiard_shot.calibration.watched import Watched
from billiard_shot.scene import Scene

CANDIDATES = 24
"""Launches at each horizon."""

KEPT = 8
"""Of these, how many go on."""

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


def horizons(last: float) -> Iterator[float]:
    """Yield horizons up to the last one [s]."""
    horizon = FIRST_HORIZON
    while horizon < last / GROWTH**0.5:
        yield horizon
        horizon *= GROWTH
    yield last


def search_launches(
    scene: Scene,
    frame: Frame,
    watched: Watched,
    scales: Floats,
    horizon: float,
    draw: np.random.Generator,
    known: Floats | None = None,
    near: bool = False,
) -> Fitted:
    """
    Search the launches of a shot.

    Parameters
    ----------
    scene : Scene
    frame : Frame
    watched : Watched
    scales : (knots,) float array
        Of errors [m], see `compare`.
    horizon : float
        Until which samples count [s].
    draw : numpy.random.Generator
    known : (n, numbers) float array, optional
        Launches that may be near the best one.
    near : bool
        Whether only launches around these are searched.

    Returns
    -------
    Fitted
        The best launches first, all different; none if none can be simulated.

    """
    last = min(horizon, watched.duration)
    launches = _starts(compare(watched, scales), draw)[: 0 if near else CANDIDATES]
    for until in [last] if near else horizons(last):
        compared = compare(watched, scales, until)
        if known is not None:
            launches = np.concatenate([known, launches])
        best = _distinct(refined(scene, frame, compared, launches, STEPS))
        launches = _drawn_around(scene, frame, compared, best, draw)
    for _ in range(LAST_ROUNDS):
        best = _distinct(refined(scene, frame, compared, launches, STEPS))
        launches = _drawn_around(scene, frame, compared, best, draw)
    return best


def _starts(compared: Comparison, draw: np.random.Generator) -> Floats:
    """Draw launches with all spins; if the stroke was commanded, take that without errors."""
    if compared.watched.command is not None:
        return compared.mean[np.newaxis]
    launches = np.repeat(compared.mean[np.newaxis], CANDIDATES, axis=0)
    speed = compared.mean[SPEED]
    launches[:, FOLLOW] = speed * draw.uniform(*FOLLOWS, CANDIDATES)
    launches[:, SIDE] = speed * draw.uniform(*SIDES, CANDIDATES)
    launches[:, SPEED] *= draw.normal(1.0, SPEED_SIGMA, CANDIDATES)
    launches[:, DIRECTION] += draw.normal(0.0, DIRECTION_SIGMA, CANDIDATES)
    return launches


def _drawn_around(
    scene: Scene, frame: Frame, compared: Comparison, best: Fitted, draw: np.random.Generator
) -> Floats:
    """Return the best launches and others around them, more around better ones."""
    if not len(best.costs):
        return _starts(compared, draw)
    if compared.watched.command is not None:
        return best.launches  # the best one is near
    matrix, _ = normal_equations(scene, frame, compared, best)
    ranks = 1.0 / np.arange(1, len(best.costs) + 1)
    chosen = draw.choice(len(ranks), CANDIDATES - len(ranks), p=ranks / ranks.sum())
    # The rows of a matrix of directions, each with the inverse of the root of its curvature.
    curvature, directions = np.linalg.eigh(matrix)
    lengths = SPREAD / np.sqrt(np.maximum(curvature, curvature[:, -1:] * 1e-12))
    free = draw.normal(size=(len(chosen), matrix.shape[-1]))
    moves = np.einsum('nik,nk->ni', directions[chosen], lengths[chosen] * free)
    return np.concatenate([best.launches, best.launches[chosen] + moves])


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
