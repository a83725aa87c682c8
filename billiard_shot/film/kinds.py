"""Which ball of a scene a track is: by its colour, and by its share of white."""

from collections.abc import Sequence

import cv2
import numpy as np
from scipy.optimize import linear_sum_assignment

from billiard_shot.film.balls import Seen
from billiard_shot.film.lens import Floats
from billiard_shot.film.tracks import Path
from billiard_shot.pictures.canvas import ball_colour, is_striped
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

MOST_COMMON = 0.5
"""Two tracks of one ball have less of the shorter one's time in common."""


def _lab(colours: Floats) -> Floats:
    rows = np.clip(colours / 255.0, 0.0, 1.0).astype(np.float32)[np.newaxis]
    return cv2.cvtColor(rows, cv2.COLOR_RGB2LAB)[0].astype(np.float64)


def _stated(name: str) -> Floats:
    """Return the colour of a ball (3,) [of 255]."""
    code = ball_colour(name)
    return np.array([int(code[k : k + 2], 16) for k in (1, 3, 5)], float)


def _scale(colours: Floats) -> float:
    """Return what makes the white of balls (n, 3) that of the stated colours."""
    return BRIGHTEST / max(float(colours.max(initial=0.0)), LEAST_WHITE)


def _apart(seen: Floats, shares: Floats, names: Sequence[str]) -> Floats:
    """Return how far colours (n, 3) of L*a*b* with shares of white (n,) are from balls."""
    known = _lab(np.array([_stated(name) for name in (*names, CUE_BALL)]))
    *each, white = np.linalg.norm(seen[:, np.newaxis] - known, axis=-1).T
    apart: Floats = np.transpose(each)
    is_striped_ball = np.array([is_striped(name) for name in names])
    is_white = np.array([name in (CUE_BALL, 'white') for name in names])
    # a ball whose white side is up shows little of its stripe
    side = np.minimum(apart, white[:, np.newaxis] + SIDE)
    side += WHITE * np.maximum(STRIPED - shares, 0.0)[:, np.newaxis]
    plain = apart + WHITE * np.abs(shares[:, np.newaxis] - is_white)
    return np.where(is_striped_ball, side, plain)


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
    colours = np.array([path.colour for path in paths])
    shares = np.array([np.mean([sight['white'] for sight in path.seen]) for path in paths])
    apart = _apart(_lab(_scale(colours) * colours), shares, names)
    rows, columns = linear_sum_assignment(apart)
    likeness = np.maximum(1.0 - apart / (2.0 * MOST_APART), 0.0)
    return [(i, names[k], float(likeness[i, k])) for i, k in zip(rows, columns, strict=True)]


def named(paths: Sequence[Path], names: Sequence[str]) -> tuple[dict[str, Seen], list[str]]:
    """
    Give tracks the names of balls.

    The longest tracks are the balls with the nearest colours. A later track continues the ball
    whose first track has the nearest colour. If two tracks of a ball overlap, as a hand took one
    of them over, neither counts during that time.

    Parameters
    ----------
    paths : sequence of Path
        They get their names.
    names : sequence of str
        Of the balls that are on the table at the beginning.

    Returns
    -------
    balls : dict of str to Seen
    notes : list of str
        Tracks that are no ball of the scene, and times that do not count, and why.

    """
    if not paths:
        return {}, []
    order = sorted(paths, key=lambda path: -len(path.seen))
    sights = [path.sights for path in order]
    colours = np.array([np.median(each['colour'], axis=0) for each in sights])
    shares = np.array([each['white'].mean() for each in sights])
    first = min(len(names), len(order))
    notes: list[str] = []
    colours = _lab(_scale(colours[:first]) * colours)
    apart = _apart(colours, shares, names)
    apart[first:] = np.inf
    rows, columns = linear_sum_assignment(apart[:first])
    parts: dict[str, list[Seen]] = {}
    for i, k in zip(rows, columns, strict=True):
        if apart[i, k] < 2.0 * MOST_APART:
            order[i].name, parts[names[k]] = names[k], [sights[i]]
            apart[first:, k] = np.linalg.norm(colours[first:] - colours[i], axis=1)
    for i, path in enumerate(order):
        for k in np.argsort(apart[i]) if i >= first else ():
            fits = apart[i, k] < MOST_APART and not path.name
            if fits and all(_follow(sights[i], each) for each in parts[names[k]]):
                path.name = names[k]
                parts[path.name].append(sights[i])
        if not path.name:
            notes.append(described(path, 'its colour is that of no ball that is missing then'))
    return {name: _joined(name, each, notes) for name, each in parts.items()}, notes


def described(path: Path, why: str) -> str:
    """Say that a track is no ball."""
    begin = path.seen[0]['time']
    return f'a spot from {begin:.2f} s on, seen {len(path.seen)} times, is no ball: {why}'


def _follow(one: Seen, other: Seen) -> bool:
    """Return whether one track follows the other, with a short time in common."""
    times, others = one['time'], other['time']
    both = min(times[-1], others[-1]) - max(times[0], others[0])
    return bool(both < MOST_COMMON * min(np.ptp(times), np.ptp(others)))


def _joined(name: str, parts: list[Seen], notes: list[str]) -> Seen:
    """Join the tracks of a ball; note the times that do not count."""
    parts = sorted(parts, key=lambda each: float(each['time'][0]))
    joined = parts[0]
    for part in parts[1:]:
        begin, end = part['time'][0], joined['time'][-1]
        if begin <= end:
            notes.append(f'{name!r} does not count from {begin:.2f} to {end:.2f} s: seen twice')
        joined = np.concatenate([joined[joined['time'] < begin], part[part['time'] > end]])
    return joined
