"""Which ball of a scene a track is: by its colour, and by its share of white."""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from scipy.optimize import linear_sum_assignment

from billiard_shot.film.lens import Floats
from billiard_shot.film.tracks import merged, Path
from billiard_shot.pictures.colours import ball_colour, is_striped
from billiard_shot.scene.placement import CUE_BALL

BRIGHTEST = 235.0
"""Of the white of a ball, to which the colours of a film are scaled [of 255]."""

LEAST_WHITE = 120.0
"""If all balls are darker, none of them is white [of 255]."""

STRIPED, WHITE = 0.4, 80.0
"""Usual share of white of a striped ball, and what a whole share costs [units of L*a*b*]."""

SIDE = 20.0
"""What it costs that a striped ball looks as white as the cue ball [units of L*a*b*]."""

MOST_APART = 60.0
"""Colours that differ more are those of other balls [units of L*a*b*]."""

OVERLAP = 0.05
"""Tracks of one ball overlap in time by less [s]."""


def _lab(colours: Floats) -> Floats:
    rows = np.clip(colours / 255.0, 0.0, 1.0).astype(np.float32)[np.newaxis]
    return cv2.cvtColor(rows, cv2.COLOR_RGB2LAB)[0].astype(np.float64)


def _stated(name: str) -> Floats:
    """Return the colour of a ball (3,) [of 255]."""
    code = ball_colour(name)
    return np.array([int(code[k : k + 2], 16) for k in (1, 3, 5)], float)


def _apart(paths: Sequence[Path], names: Sequence[str], whitest: Floats) -> Floats:
    """Return how far tracks and balls are apart (paths, names) [units of L*a*b*]."""
    scale = BRIGHTEST / max(float(whitest.max(initial=0.0)), LEAST_WHITE)
    known = _lab(np.array([_stated(name) for name in (*names, CUE_BALL)]))
    seen = _lab(scale * np.array([path.colour for path in paths]))
    shares = np.array([[np.mean(path.white)] for path in paths])
    *each, white = np.linalg.norm(seen[:, np.newaxis] - known, axis=-1).T
    apart: Floats = np.transpose(each)
    is_striped_ball = np.array([is_striped(name) for name in names])
    is_white = np.array([name in (CUE_BALL, 'white') for name in names])
    # a ball whose white side is up shows little of its stripe
    side = np.minimum(apart, white[:, np.newaxis] + SIDE) + WHITE * np.maximum(
        STRIPED - shares, 0.0
    )
    return np.where(is_striped_ball, side, apart + WHITE * np.abs(shares - is_white))


def likely_names(paths: Sequence[Path], names: Sequence[str]) -> list[tuple[int, str, float]]:
    """
    Give tracks of the last pictures the names of balls, as far as they have their colours.

    Returns
    -------
    found : list of (int, str, float)
        Index of the track, name, and how like they are, from 1 to 0; no name twice.

    """
    if not paths:
        return []
    apart = _apart(paths, names, np.array([path.colour for path in paths]))
    rows, columns = linear_sum_assignment(apart)
    likeness = np.maximum(1.0 - apart / (2.0 * MOST_APART), 0.0)
    return [(i, names[k], float(likeness[i, k])) for i, k in zip(rows, columns, strict=True)]


def named(
    paths: Sequence[Path], names: Sequence[str]
) -> tuple[Mapping[str, Path], list[tuple[Path, str]]]:
    """
    Give tracks the names of balls.

    Parameters
    ----------
    paths : sequence of Path
    names : sequence of str
        Of the balls that are on the table at the beginning.

    Returns
    -------
    balls : mapping of str to Path
    given_up : list of (Path, str)
        Tracks that are no ball of the scene, and why.

    """
    if not paths:
        return {}, []
    order = sorted(paths, key=lambda path: -len(path.time))
    colours = np.array([path.colour for path in order])
    first = min(len(names), len(order))
    apart = _apart(order[:first], names, colours[:first])
    rows, columns = linear_sum_assignment(apart)
    parts: dict[str, list[Path]] = {}
    means = np.full((len(names), 3), np.inf)
    given_up = []
    for i, k in zip(rows, columns, strict=True):
        if apart[i, k] < 2.0 * MOST_APART:
            parts[names[k]], means[k] = [order[i]], colours[i]
        else:
            given_up.append((order[i], f'its colour is not that of {names[k]!r}'))
    for i in range(first, len(order)):
        near = np.linalg.norm(means - colours[i], axis=-1)
        path = order[i]
        free = [
            k for k in np.argsort(near)
            if near[k] < MOST_APART and all(_is_apart(path, other) for other in parts[names[k]])
        ]  # fmt: skip
        if free:
            parts[names[free[0]]].append(path)
        else:
            given_up.append((path, 'no ball of the scene is missing then with this colour'))
    return {name: merged(each) for name, each in parts.items()}, given_up


def _is_apart(one: Path, other: Path) -> bool:
    return one.time[0] > other.time[-1] - OVERLAP or other.time[0] > one.time[-1] - OVERLAP
