"""
Errors of the places of the balls: balls lie elsewhere than a camera says.

The cue is moved to the place where the cue ball is believed to be. So an error of the place of
the cue ball is also an error of the contact point of the tip.
"""

from itertools import combinations

import numpy as np

from billiard_shot.planning.problem import Problem
from billiard_shot.records import Array
from billiard_shot.shot.strike_model import tip_reach
from billiard_shot.table.table_states import TableStates

NEAR_SIGMAS = 12.0
"""Balls that are farther apart than this number of standard deviations never overlap."""


def draw_places(problem: Problem, draw: np.random.Generator, count: int) -> Array | None:
    """
    Draw where the balls really lie, (count, balls, 2) [m]; None if their places are exact.

    Balls that overlap are moved apart along the line of their centres, by the same distance each.
    If some overlap even then, all balls of that table lie where they are believed to lie.
    """
    sigma = problem.noise.balls
    if not sigma:
        return None
    places = problem.places + sigma * draw.standard_normal((count, *problem.places.shape))
    half = np.array(problem.half_sizes)
    places = np.clip(places, -half, half)
    believed, apart = problem.places, 2.0 * problem.radius
    near = [
        (i, k)
        for i, k in combinations(range(len(believed)), 2)
        if np.hypot(*(believed[i] - believed[k])) < apart + NEAR_SIGMAS * sigma
    ]
    for i, k in near:
        way = places[:, k] - places[:, i]
        distance = np.hypot(way[:, 0], way[:, 1])
        push = 0.5 * np.maximum(apart - distance, 0.0) / np.maximum(distance, 1e-9)
        places[:, i] -= push[:, np.newaxis] * way
        places[:, k] += push[:, np.newaxis] * way
    for i, k in near:
        way = places[:, k] - places[:, i]
        places[np.hypot(way[:, 0], way[:, 1]) < apart - 1e-9] = believed
    return places


def for_each(strokes: int, places: Array | None) -> Array | None:
    """Repeat drawn places for each of a number of strokes."""
    return None if places is None else np.tile(places, (strokes, 1, 1))


def as_struck(problem: Problem, strokes: Array, places: Array) -> Array:
    """
    Find strokes (n, 5) relative to the cue balls that they meet.

    The contact point moves less than the cue ball does, because the tip is round.

    Parameters
    ----------
    problem : Problem
    strokes : (n, 5) float array
        Relative to the place where the cue ball is believed to be.
    places : (n, balls, 2) float array
        Of the balls [m].

    """
    met = strokes.copy()
    _, _, elevation, azimuth, _ = strokes.T
    x, y = (places[:, 0] - problem.cue_ball).T / tip_reach(problem.model)
    met[:, 0] -= x * np.sin(azimuth) - y * np.cos(azimuth)
    met[:, 1] -= (x * np.cos(azimuth) + y * np.sin(azimuth)) * np.sin(elevation)
    return met


def tables_at(problem: Problem, places: Array) -> TableStates:
    """Make tables whose balls lie at places (n, balls, 2) [m]."""
    height = np.full((*places.shape[:2], 1), problem.radius)
    return TableStates(problem.names, np.concatenate([places, height], axis=2))
