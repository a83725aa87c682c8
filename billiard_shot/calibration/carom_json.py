"""
Recordings of the repository tailuge/billiards (dist/fit), read from JSON.

The file is a list of shots: `id`, and `balls`, which has `t` [s], `x` and `y` [m] of each ball. A
sample follows the one before only after a movement, so that a ball at rest has few of them.
"""

from collections.abc import Iterator
import json
from pathlib import Path
from typing import Any

import numpy as np

from billiard_shot.calibration.csv_file import check_size
from billiard_shot.calibration.recording import Floats, RecordedShot, Recording, Track, USUAL_SIGMA
from billiard_shot.scene.errors import reason

LEAST_MOVEMENT = 3e-3
"""Between samples of a ball that lie nearer to each other, the ball was at rest [m]."""

REST_PERIOD = 0.1
"""Time between samples that stand for a ball at rest [s]."""


def read_carom_json(path: Path) -> Recording:
    """
    Read such a file; the ball whose second sample comes first was struck.

    Raises
    ------
    ValueError
        Naming the file and the shot, if it is not of this kind.

    """
    try:
        check_size(path)
        listed = json.loads(path.read_text(encoding='utf-8'))
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from None
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f'{path}: must be a text in JSON ({error})') from None
    if not isinstance(listed, list):
        raise ValueError(f'{path}: must be a list of shots')
    return Recording(str(path), tuple(_shots(path, listed)))


def _shots(path: Path, listed: list[Any]) -> Iterator[RecordedShot]:
    for number, shot in enumerate(listed):
        try:
            tracks = {str(name): _track(rows) for name, rows in shot['balls'].items()}
            yield RecordedShot(str(shot['id']), tracks)
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise ValueError(
                f'{path}: shot {number}: must have id, and t, x and y of each of its balls '
                f'({type(error).__name__}: {error})'
            ) from None


def _track(rows: Any) -> Track:
    time, x, y = (np.array(rows[name], float) for name in ('t', 'x', 'y'))
    place = np.stack([x, y], axis=-1)
    seen = np.isfinite(time) & np.isfinite(place).all(axis=-1)
    if not seen.any():
        raise ValueError('a ball without samples')
    time, place = time[seen], place[seen]
    time, first = np.unique(time, return_index=True)
    time, place = _with_rests(time, place[first])
    return Track(time, place, np.full(len(time), USUAL_SIGMA))


def _with_rests(time: Floats, place: Floats) -> tuple[Floats, Floats]:
    """Add samples while a ball was at rest."""
    times, places = [time[:1]], [place[:1]]
    for i in range(1, len(time)):
        if np.linalg.norm(place[i] - place[i - 1]) < LEAST_MOVEMENT:
            added = np.arange(time[i - 1] + REST_PERIOD, time[i], REST_PERIOD)
            times.append(added)
            places.append(np.repeat(place[i - 1][np.newaxis], len(added), axis=0))
        times.append(time[i : i + 1])
        places.append(place[i : i + 1])
    return np.concatenate(times), np.concatenate(places)
