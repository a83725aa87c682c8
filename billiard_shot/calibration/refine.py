"""
Launches improved by least squares, many of one shot at once.

Gauss-Newton steps with the damping of Levenberg and Marquardt (Nocedal and Wright, Numerical
Optimization, 2nd ed., section 10.3), weighted again in each step (Holland and Welsch, Commun.
Stat. A 6 (1977)). All launches and all steps of differences are simulated in one batch.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.calibration.comparison import Comparison
from billiard_shot.calibration.launch import steps_of, ways_of
from billiard_shot.calibration.recording import Floats, Frame
from billiard_shot.scene import Scene

DAMPINGS = np.array([1e-3, 1e-1, 10.0])
"""Factors of the last damping, all of which are tried."""

FIRST_DAMPING, LEAST_DAMPING, MOST_DAMPING, RAISED = 1.0, 1e-4, 1e4, 30.0
"""Damping relative to the diagonal, its bounds, and its factor if no step was better."""

ENOUGH, EXACT = 1e-3, 1e-7
"""A launch is done if a step lowers its cost by less than this part: in searches, and in fits."""


class Fitted(NamedTuple):
    """
    Launches of a shot.

    Attributes
    ----------
    launches : (n, numbers) float array
    costs : (n,) float array
        Infinite for a launch that cannot be simulated.
    places : (n, samples, 2) float array
        Where the samples would lie [m].

    """

    launches: Floats
    costs: Floats
    places: Floats

    def take(self, which: NDArray[np.integer]) -> 'Fitted':
        """Return some of the launches."""
        return Fitted(*(each[which] for each in self))


def derivatives_of(
    scene: Scene, frame: Frame, compared: Comparison, fitted: Fitted
) -> tuple[Floats, Floats]:
    """
    Return the errors (n, samples, 2) of launches, and their derivatives (n, numbers, 2 samples).

    Derivatives that do not exist, because a launch nearby cannot be simulated, are zero.
    """
    steps = steps_of(compared.watched)
    n, numbers = fitted.launches.shape
    rows = (fitted.launches[:, np.newaxis] + np.diag(steps)).reshape(n * numbers, numbers)
    moved = ways_of(scene, frame, compared.watched, rows).reshape(n, numbers, -1, 2)
    with np.errstate(invalid='ignore'):
        slopes = (moved - fitted.places[:, np.newaxis]) / steps[:, np.newaxis, np.newaxis]
    slopes[~np.isfinite(slopes)] = 0.0
    errors = fitted.places - compared.watched.place
    return errors, slopes.reshape(n, numbers, -1)


def normal_equations(
    scene: Scene, frame: Frame, compared: Comparison, fitted: Fitted
) -> tuple[Floats, Floats]:
    """Return the matrices (n, numbers, numbers) and gradients (n, numbers) of launches."""
    errors, slopes = derivatives_of(scene, frame, compared, fitted)
    weighted = slopes * compared.weights(errors)[:, np.newaxis]
    matrix = weighted @ slopes.transpose(0, 2, 1) + compared.precision
    gradient = np.einsum('nks,ns->nk', weighted, errors.reshape(len(errors), -1))
    return matrix, gradient + (fitted.launches - compared.mean) @ compared.precision


def evaluated(scene: Scene, frame: Frame, compared: Comparison, launches: Floats) -> Fitted:
    """Simulate launches (n, numbers), and compare."""
    places = ways_of(scene, frame, compared.watched, launches)
    return Fitted(launches, compared.costs(launches, places), places)


def refined(
    scene: Scene,
    frame: Frame,
    compared: Comparison,
    launches: Floats,
    steps: int,
    enough: float = ENOUGH,
) -> Fitted:
    """
    Improve launches (n, numbers) by a number of steps; those that are impossible stay.

    `compared.mean` is one for all launches (numbers,), or one for each (n, numbers).
    """
    fitted = evaluated(scene, frame, compared, np.array(launches))
    n, numbers = fitted.launches.shape
    means = np.broadcast_to(compared.mean, (n, numbers))
    damping = np.full(n, FIRST_DAMPING)
    left = np.flatnonzero(np.isfinite(fitted.costs))
    for _ in range(steps):
        if not len(left):
            break
        here = replace(compared, mean=means[left])
        matrix, gradient = normal_equations(scene, frame, here, fitted.take(left))
        factors = damping[left, np.newaxis] * DAMPINGS  # (left, tries)
        diagonal = np.einsum('nkk->nk', matrix)[:, np.newaxis, :, np.newaxis] * np.eye(numbers)
        damped = matrix[:, np.newaxis] + factors[..., np.newaxis, np.newaxis] * diagonal
        moves = np.linalg.solve(damped, gradient[:, np.newaxis, :, np.newaxis])[..., 0]
        tried = (fitted.launches[left, np.newaxis] - moves).reshape(-1, numbers)
        here = replace(compared, mean=np.repeat(means[left], len(DAMPINGS), axis=0))
        found = evaluated(scene, frame, here, tried)
        best = found.costs.reshape(len(left), -1).argmin(axis=-1)
        rows = np.arange(len(left)) * len(DAMPINGS) + best
        gain = fitted.costs[left] - found.costs[rows]
        better = gain > 0.0
        for kept, new in zip(fitted, found.take(rows), strict=True):
            kept[left[better]] = new[better]
        damping[left] *= np.where(better, DAMPINGS[best], RAISED)
        damping = np.maximum(damping, LEAST_DAMPING)
        done = np.where(better, gain < enough * fitted.costs[left], damping[left] > MOST_DAMPING)
        left = left[~done]
    return fitted
