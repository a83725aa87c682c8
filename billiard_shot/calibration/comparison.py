"""
How far a launch is from a recorded shot: a robust sum over samples, and how likely the launch is.

A sample that errs by r counts log(1 + (r / s)^2), as if errors had the distribution of Cauchy
with the scale s: a path that leaves the recorded one after a collision does not outweigh all
others. The scale grows with time, as the errors of predictions do.
"""

from dataclasses import dataclass

import numpy as np

from billiard_shot.calibration.launch import prior_of
from billiard_shot.calibration.recording import Floats
from billiard_shot.calibration.watched import Watched

SAMPLE_TIME = 0.1
"""Errors within this time are alike [s]: samples of one ball within it count as one."""

KNOTS = np.array([0.0, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0])
"""Times between which scales are interpolated [s]."""

FIRST_SCALES = np.array([1e-3, 1.5e-3, 3e-3, 7e-3, 18e-3, 40e-3, 80e-3])
"""Scales at these times before anything is known [m]: those of a table that is not known well."""

LEAST_SCALE = 1e-3
"""Smallest scale [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """
    What launches of a shot are compared with.

    Attributes
    ----------
    watched : Watched
    mean, precision : (numbers,) or (n, numbers), and (numbers, numbers) float array
        Likely numbers of the launch, or of each one, and the inverse of their covariance.
    square : (samples,) float array
        Squares of the scales [m^2].
    share : (samples,) float array
        For how many independent samples each one stands.

    """

    watched: Watched
    mean: Floats
    precision: Floats
    square: Floats
    share: Floats

    def costs(self, launches: Floats, places: Floats) -> Floats:
        """Return the costs (n,) of launches, after which samples lie at places (n, samples, 2)."""
        away = launches - self.mean
        costs: Floats = self.sums(places) + np.einsum('ni,ij,nj->n', away, self.precision, away)
        return costs

    def sums(self, places: Floats) -> Floats:
        """Return the sums (n,) over samples at places (n, samples, 2)."""
        with np.errstate(invalid='ignore', over='ignore'):
            errors = np.log1p(((places - self.watched.place) ** 2).sum(axis=-1) / self.square)
        sums: Floats = errors @ self.share
        return sums

    def weights(self, errors: Floats) -> Floats:
        """
        Return the weights (n, 2 samples) [1/m^2] of errors (n, samples, 2) in least squares.

        With them, the gradient is that of the cost, but for a factor of 2.
        """
        weights: Floats = self.share / (self.square + (errors**2).sum(axis=-1))
        return np.repeat(weights, 2, axis=-1)

    def curvatures(self, errors: Floats) -> Floats:
        """
        Return the curvatures (n, 2 samples) [1/m^2] of the cost, but for a factor of 2.

        They are means over all directions of an error. Weights are larger: deviations that follow
        from them are too small.
        """
        both = self.square + (errors**2).sum(axis=-1)
        return np.repeat(self.share * self.square / both**2, 2, axis=-1)


def compare(watched: Watched, scales: Floats, horizon: float | Floats = np.inf) -> Comparison:
    """Compare with a shot's samples until a horizon, see `Watched.until`; scales (knots,) [m]."""
    seen = watched.until(horizon)
    scale = np.interp(seen.times[seen.at], KNOTS, scales)
    return Comparison(seen, *prior_of(watched), scale**2 + seen.sigma**2, seen.share / SAMPLE_TIME)


def scales_of(times: Floats, errors: Floats) -> Floats:
    """
    Return the scales (knots,) [m] of errors (n,) [m] of samples at times (n,) [s].

    After the last sample, the first scales stand.
    """
    scales, last = np.zeros(len(KNOTS)), LEAST_SCALE
    edges = np.concatenate([[0.0], 0.5 * (KNOTS[1:] + KNOTS[:-1]), [np.inf]])
    for k in range(len(KNOTS)):
        inside = (times >= edges[k]) & (times < edges[k + 1])
        if inside.any():
            last = max(float(np.median(errors[inside])), last)
        elif not (times > edges[k]).any():
            last = max(FIRST_SCALES[k], last)
        scales[k] = last
    return scales
