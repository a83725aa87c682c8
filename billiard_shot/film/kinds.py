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

STRIPED, WHITE = 0.4, 80.0
"""Mean share of white of a striped ball, and what a whole share costs [units of L*a*b*]."""

MOST_APART = 60.0
"""Colours that differ more are those of other balls [units of L*a*b*]."""

OVERLAP = 0.05
"""Tracks of one ball overlap in time by less [s]."""


def _lab(colours: Floats) -> Floats:
    rows = np.clip(colours / 255.0, 0.0, 1.0).astype(np.float32)[np.newaxis]
    return cv2.cvtColor(rows, cv2.COLOR_RGB2LAB)[0].astype(np.float64)


def _stated(name: str) -> tuple[list[int], float]:
    """Return the colour of a ball [of 255], and its share of white."""
    code = ball_colour(name)
    colour = [int(code[k : k + 2], 16) for k in (1, 3, 5)]
    white = 1.0 if name in (CUE_BALL, 'white') else STRIPED if is_striped(name) else 0.0
    return colour, white


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
    shares = np.array([np.mean(path.white) for path in order])
    scale = BRIGHTEST / max(float(colours[: len(names)].max()), 1.0)
    stated = [_stated(name) for name in names]
    seen, known = _lab(scale * colours), _lab(np.array([each[0] for each in stated], float))
    apart = np.linalg.norm(seen[:, np.newaxis] - known, axis=-1)
    apart += WHITE * np.abs(shares[:, np.newaxis] - [each[1] for each in stated])
    first = min(len(names), len(order))
    rows, columns = linear_sum_assignment(apart[:first])
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
