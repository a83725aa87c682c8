"""Random and quasi-random numbers, and confidence intervals of success probabilities."""

import math

import numpy as np

from billiard_shot.records import Array

FEW_TRIALS = 100  # fewer are stated as a count, not in per cent
Z95 = 1.959963984540054  # quantile of a two-sided 95 % interval


def wilson_interval(successes: float, trials: int, z: float = Z95) -> tuple[float, float]:
    """
    Compute the confidence interval of a probability (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927).

    It is also valid near 0 and 1, unlike the normal approximation. Without trials it is (0, 1).
    """
    if trials == 0:
        return 0.0, 1.0
    p, square = successes / trials, z * z / trials
    middle = (p + 0.5 * square) / (1.0 + square)
    half = z / (1.0 + square) * math.sqrt(p * (1.0 - p) / trials + 0.25 * square / trials)
    return max(0.0, min(p, middle - half)), min(1.0, max(p, middle + half))  # p but for rounding


def chance_in_words(success: float, trials: int) -> str:
    """Write a share of trials, such as `85 %`; as a count if they are few or all succeeded."""
    if trials < FEW_TRIALS or success == 1.0:
        return f'in {round(success * trials)} of {trials} trials'
    return f'{percent(success)} %'


def estimate_in_words(success: float, trials: int, interval: tuple[float, float]) -> str:
    """Write a share of trials and its 95 % interval, such as `85 % (95 % CI 79 to 89 %)`."""
    return f'{chance_in_words(success, trials)} ({interval_in_words(interval)})'


def interval_in_words(interval: tuple[float, float]) -> str:
    """Write a 95 % interval, such as `95 % CI 79 to 89 %`."""
    low, high = interval
    return f'95 % CI {percent(low)} to {percent(high)} %'


def percent(probability: float) -> str:
    """Write a probability in per cent, with enough digits to distinguish it from 0 and 100."""
    for digits in range(4):
        text = f'{100.0 * probability:.{digits}f}'
        if not 1e-9 < probability < 1.0 - 1e-9 or 0.0 < float(text) < 100.0:
            return text
    return text


def quasi_random(count: int, dimensions: int, skip: int = 0) -> Array:
    """
    Return points (count, dimensions) that fill the unit cube evenly, without the first `skip`.

    Multiples of powers of a generalized golden ratio, modulo 1 (M. Roberts, "The unreasonable
    effectiveness of quasirandom sequences", 2018). A Halton or Sobol sequence does the same, but
    the import of scipy.stats takes a second.
    """
    ratio = 2.0
    for _ in range(60):
        ratio = (1.0 + ratio) ** (1.0 / (dimensions + 1))
    steps = ratio ** -np.arange(1.0, dimensions + 1)
    points: Array = (0.5 + np.arange(skip + 1, skip + count + 1)[:, np.newaxis] * steps) % 1.0
    return points
