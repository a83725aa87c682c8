"""Sightings of balls: where a ball was detected, how surely, and whether it lies as planned."""

from collections.abc import Mapping
from dataclasses import dataclass
import math

SURE_SIGMAS = 4.0
"""
Number of standard deviations beyond which a distance between two sightings is not noise.

Two sightings of one place differ by more with a probability of exp(-8), about 1 in 3000 (Rayleigh
distribution), and the tolerance comes on top.
"""


@dataclass(frozen=True, slots=True)
class Sighting:
    """One ball, as it was last detected."""

    position: tuple[float, float]  # centre, x and y in the frame `table`, m
    # xx, xy, yy, m^2, without errors that all pictures have in common; zeros: exact
    covariance: tuple[float, float, float] = (0.0, 0.0, 0.0)
    is_seen: bool = True  # at present; if it is not seen, it may be anywhere
    is_moving: bool = False
    time: float = 0.0  # of the last detection, on the clock of the messages, s; 0: not known
    systematic_error: float = 0.0  # of x and y, in all pictures: standard deviation, m

    @property
    def deviation(self) -> float:
        """
        Standard deviation of a coordinate from where the ball is [m]; 0 if the place is exact.

        It is the root of the mean of both variances, with the systematic error.
        """
        xx, _, yy = self.covariance
        return math.sqrt(0.5 * (xx + yy) + self.systematic_error**2)


Balls = Mapping[str, Sighting]


def largest_deviation(balls: Balls) -> float:
    """Largest standard deviation of a coordinate of a ball [m]; 0 if all positions are exact."""
    return max((each.deviation for each in balls.values()), default=0.0)


def moved(planned: Balls, seen: Balls, tolerance: float, may_be_hidden: bool = False) -> str:
    """
    Return which ball does not lie at its planned place; '' if all do.

    A ball lies elsewhere if its distance from the planned place is more than `tolerance` [m] plus
    `SURE_SIGMAS` standard deviations of that distance. The errors of both positions are
    independent; systematic errors are the same in both, and do not count. A ball that is not seen
    lies where it was last seen if it `may_be_hidden`.
    """
    for name in sorted(planned.keys() | seen.keys()):
        if name not in seen:
            return f'ball {name!r} of the plan is not on the table'
        if name not in planned:
            return f'ball {name!r} is on the table, but not in the plan'
        if not (seen[name].is_seen or may_be_hidden):
            return f'ball {name!r} is not seen'
        if seen[name].is_moving:
            return f'ball {name!r} moves'
        distance, deviation = distance_between(planned[name], seen[name])
        allowed = tolerance + SURE_SIGMAS * deviation
        if not distance <= allowed:
            return (
                f'ball {name!r} lies {1e3 * distance:.3g} mm from its planned place; must be at '
                f'most {1e3 * allowed:.3g} mm'
            )
    return ''


def uncertain(planned: Balls, seen: Balls, limit: float) -> str:
    """
    Return which ball has an uncertain distance from its planned place; '' if none has.

    The distance is certain if `SURE_SIGMAS` of its standard deviations are at most `limit` [m] in
    every direction, because a distance of zero has none.
    """
    for name in sorted(planned.keys() & seen.keys()):
        covariances = planned[name].covariance, seen[name].covariance
        xx, xy, yy = (a + b for a, b in zip(*covariances, strict=True))
        largest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)  # eigenvalue
        if not (error := SURE_SIGMAS * math.sqrt(max(largest, 0.0))) <= limit:
            return (
                f'ball {name!r}: {SURE_SIGMAS:g} standard deviations of its distance from the '
                f'planned place must be at most {1e3 * limit:g} mm, got {1e3 * error:.3g} mm'
            )
    return ''


def distance_between(one: Sighting, other: Sighting) -> tuple[float, float]:
    """Distance of two sightings [m], and the standard deviation of the distance [m]."""
    dx, dy = (b - a for a, b in zip(one.position, other.position, strict=True))
    distance = math.hypot(dx, dy)
    xx, xy, yy = (a + b for a, b in zip(one.covariance, other.covariance, strict=True))
    if not distance > 0.0:
        return distance, 0.0
    u, v = dx / distance, dy / distance
    variance = u * u * xx + 2.0 * u * v * xy + v * v * yy
    return distance, math.sqrt(max(variance, 0.0))
