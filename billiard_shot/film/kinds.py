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

FARTHEST, ALIKE = 120.0, 60.0
"""
What differs more from the stated look of a ball, and from its first track, is another one.

The first is larger, as it holds a share of white, and the light of the room [units of L*a*b*].
"""

MOST_COMMON = 0.5
"""Two tracks of one ball have less of the shorter one's time in common."""


def _lab(colours: Floats) -> Floats:
    rows = np.clip(colours / 255.0, 0.0, 1.0).astype(np.float32)[np.newaxis]
    return cv2.cvtColor(rows, cv2.COLOR_RGB2LAB)[0].astype(np.float64)


def _stated(name: str) -> Floats:
    """Return the colour of a ball (3,) [of 255]."""
    code = ball_colour(name)
    return np.array([int(code[k : k + 2], 16) for k in (1, 3, 5)], float)


def _looks(paths: Sequence[Path]) -> tuple[Floats, Floats]:
    """Return colours (n, 3) of L*a*b* of tracks, and their shares of white (n,)."""
    sights = [path.sights for path in paths]
    colours = np.array([np.median(each['colour'], axis=0) for each in sights]).reshape(-1, 3)
    colours *= BRIGHTEST / max(float(colours.max(initial=0.0)), LEAST_WHITE)
    return _lab(colours), np.array([each['white'].mean() for each in sights])


def likely_names(paths: Sequence[Path], names: Sequence[str]) -> list[tuple[Path, str, float]]:
    """
    Give tracks the names of balls whose colours and white they have.

    Returns
    -------
    found : list of (Path, str, float)
        Tracks, names, and how like they are, from 1 to 0; no name twice.

    """
    if not paths:
        return []
    colours, shares = _looks(paths)
    known = _lab(np.array([_stated(name) for name in (*names, CUE_BALL)]))
    away = np.linalg.norm(colours[:, np.newaxis] - known, axis=-1)
    apart, white, share = away[:, :-1], away[:, -1:], shares[:, np.newaxis]
    is_white = np.array([name in (CUE_BALL, 'white') for name in names])
    # a ball whose white side is up shows little of its stripe
    side = np.minimum(apart, white + SIDE) + WHITE * np.maximum(STRIPED - share, 0.0)
    plain = apart + WHITE * np.abs(share - is_white)
    apart = np.where([is_striped(name) for name in names], side, plain)
    rows, columns = linear_sum_assignment(apart)
    likeness = np.maximum(1.0 - apart / FARTHEST, 0.0)
    return [
        (paths[i], names[k], float(likeness[i, k])) for i, k in zip(rows, columns, strict=True)
    ]


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
    order = sorted(paths, key=lambda path: -len(path.seen))
    parts: dict[str, list[Path]] = {}
    for path, name, likeness in likely_names(order[: len(names)], names):
        if likeness > 0.0:
            path.name, parts[name] = name, [path]
    colours = dict(zip(order, _looks(order)[0], strict=True))
    for path in order[len(names) :]:
        away = {
            name: np.linalg.norm(colours[path] - colours[own[0]]) for name, own in parts.items()
        }
        for name in sorted(parts, key=lambda name: away[name]):
            if away[name] < ALIKE and all(
                _follow(path.sights, each.sights) for each in parts[name]
            ):
                path.name = name
                parts[name].append(path)
                break
    why = 'its colour is that of no ball that is missing then'
    notes = [described(path, why) for path in order if not path.name]
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


def _joined(name: str, paths: list[Path], notes: list[str]) -> Seen:
    """Join the tracks of a ball; note the times that do not count."""
    joined, *parts = sorted((path.sights for path in paths), key=lambda each: each['time'][0])
    for part in parts:
        begin, end = part['time'][0], joined['time'][-1]
        if begin <= end:
            notes.append(f'{name!r} does not count from {begin:.2f} to {end:.2f} s: seen twice')
        joined = np.concatenate([joined[joined['time'] < begin], part[part['time'] > end]])
    return joined
