"""
How surely shots decide each common number, and which of the shots do.

Each shot is left out in turn (the jackknife of Tukey, Ann. Math. Stat. 29 (1958); Efron and
Stein, Ann. Stat. 9 (1981)): one Gauss-Newton step from the fit leads to the numbers that the other
shots give. These fits are close to each other, and a step takes no simulation. With few shots this
is more careful than drawing shots with replacement: it undoes that a fit follows each shot.
"""

from typing import NamedTuple

import numpy as np
from scipy.stats import t as student

from billiard_shot.calibration.joint_fit import JointFit, Problem
from billiard_shot.calibration.recording import Floats

LEVEL = 0.95
"""Part of the intervals that shall hold the truth."""

HELD = 0.1
"""Part of the variance of a number that its range must not explain."""

DECISIVE = 3
"""How many shots are named that decide a number."""


class Interval(NamedTuple):
    """The bounds of an interval, and the shots that decide it, the most important one first."""

    bounds: tuple[float, float]
    shots: tuple[str, ...]


def intervals_of(problem: Problem, fit: JointFit) -> list[Interval]:
    """Return the intervals of the common numbers."""
    count = len(fit.shots)
    left = without_each(problem, fit)
    variance = (count - 1) / count * ((left - left.mean(axis=0)) ** 2).sum(axis=0)
    reach = student.ppf(0.5 + 0.5 * LEVEL, count - 1) * np.sqrt(variance)
    inverse = np.linalg.inv(fit.curvatures.sum(axis=0) + problem.precision)
    shares = np.einsum('ki,sij,kj->ks', inverse, fit.curvatures, inverse)
    decisive = np.argsort(-shares, axis=-1, kind='stable')[:, :DECISIVE]
    return [
        Interval(
            (max(value - by, each.low), min(value + by, each.high)),
            tuple(fit.shots[s].watched.name for s in shots),
        )
        for each, value, by, shots in zip(
            problem.sought, fit.values.tolist(), reach.tolist(), decisive.tolist(), strict=True
        )
    ]


def without_each(problem: Problem, fit: JointFit) -> Floats:
    """Return the common numbers (shots, common) that all shots but one give."""
    away = problem.precision @ (fit.values - problem.start)
    matrices = fit.curvatures.sum(axis=0) + problem.precision - fit.curvatures
    gradients = fit.gradients.sum(axis=0) + away - fit.gradients
    left: Floats = fit.values - np.linalg.solve(matrices, gradients[..., np.newaxis])[..., 0]
    return left


def undecided(problem: Problem, fit: JointFit, intervals: list[Interval]) -> list[int]:
    """
    Return the numbers that the shots may not decide, the least decided one first.

    A number is decided if its interval is narrower than the range of likely values, or does not
    hold the value with which the fit began. It is not if its range alone keeps it where it is.
    """
    inverse = np.linalg.inv(fit.curvatures.sum(axis=0) + problem.precision)
    held = np.diag(inverse) * np.diag(problem.precision)  # 1: nothing is known but the range
    parts = []
    for each, (low, high), by_range in zip(
        problem.sought, (interval.bounds for interval in intervals), held.tolist(), strict=True
    ):
        inside = low <= each.start <= high
        parts.append(max((high - low) / each.width if inside else 0.0, by_range / HELD))
    order = np.argsort([-part for part in parts], kind='stable').tolist()
    return [k for k in order if parts[k] > 1.0]
