"""Chances: the noise of strokes, drawn in common for all that are compared, and intervals."""

import math

import numpy as np

from billiard_shot.planning.problem import Problem
from billiard_shot.planning.strikes import Rows

Z95 = 1.959963984540054  # of a two-sided interval of 95 %


def wilson(successes: float, trials: int, z: float = Z95) -> tuple[float, float]:
    """
    Interval of a probability after so many successes (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927).

    Right also near 0 and 1, where the usual one is not. Without any trial it is (0, 1).
    """
    if trials == 0:
        return 0.0, 1.0
    p, square = successes / trials, z * z / trials
    middle = (p + 0.5 * square) / (1.0 + square)
    half = z / (1.0 + square) * math.sqrt(p * (1.0 - p) / trials + 0.25 * square / trials)
    return max(0.0, middle - half), min(1.0, middle + half)


def errors(problem: Problem, draw: np.random.Generator, count: int) -> Rows:
    """Errors (count, 5) of strokes, normal and independent, in the units of the strokes."""
    drawn: Rows = draw.standard_normal((count, 5)) * problem.sigmas
    return drawn
