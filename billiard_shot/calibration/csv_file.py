"""
Recordings as CSV: a line for each sight of a ball, with the header `shot,time,ball,x,y`.

Times are in s, places in m, in the frame `table` unless the description of the recording states
another one. Further columns: `sigma`, the standard deviation of x and y [m], and `z` [m]. A line
whose x or y is empty or NaN is a ball that was not detected. Lines may come in any order, and at
any rate.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
import csv
import math
from pathlib import Path
from typing import TextIO

import numpy as np

from billiard_shot.calibration.recording import RecordedShot, Recording, Track, USUAL_SIGMA
from billiard_shot.scene.errors import InputError, Mistake, MOST_MISTAKES, must_be, reason, unknown
from billiard_shot.scene.fields import A_NAME, fits_name

NEEDED, OPTIONAL = ('shot', 'time', 'ball', 'x', 'y'), ('sigma', 'z')
WRITTEN = *NEEDED, 'sigma'
NUMBERS = {  # unit, and bounds of the values
    'time': ('s', -1e7, 1e7),
    'x': ('m', -10.0, 10.0),
    'y': ('m', -10.0, 10.0),
    'z': ('m', -1.0, 10.0),
    'sigma': ('m', 1e-6, 0.1),
}
LOST = 'x', 'y'  # columns that are empty if the ball was not detected

MOST_BYTES = 2**28
"""Largest size of a file: some five million lines."""

LONGEST_SHOT = 120.0
"""Longest time from the first to the last sight of a shot [s]."""

Sights = dict[str, dict[str, list[tuple[float, float, float, float]]]]  # time, x, y, sigma


def read_csv(path: Path, sigma: float = USUAL_SIGMA) -> Recording:
    """
    Read the shots of a recording.

    Parameters
    ----------
    path : Path
    sigma : float
        Standard deviation of x and y [m] of lines that state none.

    Raises
    ------
    ValueError
        Naming the file, the lines and the fields that make no sense.

    """
    with opened(path) as file:
        check_size(path)
        return _read(path, file, sigma)


@contextmanager
def opened(path: Path) -> Iterator[TextIO]:
    """Open a file in CSV; ValueError names a file that cannot be read, or is none."""
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            yield file
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f'{path}: must be a text in CSV ({error})') from None


def check_size(path: Path) -> None:
    """Raise a ValueError if a file is too large to be read at once."""
    if (size := path.stat().st_size) > MOST_BYTES:
        raise ValueError(
            f'{path}: must have at most {MOST_BYTES} bytes, got {size}; divide it by shots'
        )


def write_csv(recording: Recording, path: Path) -> None:
    """Write the shots of a recording."""
    with path.open('w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file)
        writer.writerow(WRITTEN)
        for shot in recording.shots:
            for name, track in shot.tracks.items():
                for time, (x, y), sigma in zip(
                    track.time.tolist(), track.place.tolist(), track.sigma.tolist(), strict=True
                ):
                    writer.writerow(
                        [shot.name, f'{time:.6g}', name, f'{x:.6g}', f'{y:.6g}', sigma]
                    )


def _read(path: Path, file: TextIO, sigma: float) -> Recording:
    rows = csv.reader(file)
    header = [word.strip() for word in next(rows, [])]
    mistakes = list(_mistakes_of_header(header))
    if mistakes:
        raise InputError(mistakes, str(path))
    sights: Sights = {}
    lost = 0
    for row in rows:
        if not row:
            continue
        try:
            lost += not _note(sights, dict(zip(header, row, strict=True)), sigma)
        except InputError as error:
            mistakes += [each._replace(line=rows.line_num) for each in error.mistakes]
        except ValueError:
            text = must_be(f'{len(header)} fields, as in the header', row)
            mistakes.append(Mistake((), f'a line {text}', rows.line_num))
        if len(mistakes) > MOST_MISTAKES:
            break
    if mistakes:
        raise InputError(mistakes, str(path))
    if not sights:
        raise ValueError(f'{path}: must have a line for each sight of a ball, got none')
    ignored = [f'{lost} lines without x or y: the balls were not detected'] if lost else []
    shots = tuple(_shots(path, sights, ignored))
    return Recording(str(path), shots, ignored=tuple(ignored))


def _mistakes_of_header(header: list[str]) -> Iterator[Mistake]:
    known = (*NEEDED, *OPTIONAL)
    for name in NEEDED:
        if name not in header:
            yield Mistake((name,), f'is missing in the header; it must be {",".join(NEEDED)}', 1)
    for name in header:
        if name not in known:
            yield Mistake((name,), unknown(name, known), 1)
        elif header.count(name) > 1:
            yield Mistake((name,), 'is there twice', 1)


def _note(sights: Sights, row: dict[str, str], sigma: float) -> bool:
    """Note a sight; return whether there is one. InputError names the fields that are wrong."""
    mistakes, numbers = [], {'sigma': sigma}
    for name in ('shot', 'ball'):
        if not fits_name(row[name].strip()):
            mistakes.append(Mistake((name,), must_be(A_NAME, row[name])))
    for name, (unit, low, high) in NUMBERS.items():
        if name not in row or (name in OPTIONAL and not row[name].strip()):
            continue
        number = _number(row[name])
        if number is None and name in LOST:
            numbers[name] = math.nan
        elif number is None or not low <= number <= high:
            hint = _other_unit(number, unit, high)
            allowed = f'a number from {low:g} to {high:g}'
            mistakes.append(Mistake((name,), must_be(allowed, row[name], unit) + hint))
        else:
            numbers[name] = number
    if mistakes:
        raise InputError(mistakes)
    tracks = sights.setdefault(row['shot'].strip(), {})
    if math.isnan(numbers['x'] + numbers['y']):
        return False
    sight = numbers['time'], numbers['x'], numbers['y'], numbers['sigma']
    tracks.setdefault(row['ball'].strip(), []).append(sight)
    return True


def _number(text: str) -> float | None:
    """Read a number; None if it is empty or NaN, infinite if it is something else."""
    if not text.strip():
        return None
    try:
        number = float(text)
    except ValueError:
        return math.inf
    return None if math.isnan(number) else number


def _other_unit(number: float | None, unit: str, high: float) -> str:
    """Ask whether a place is in another unit."""
    if number is None or unit != 'm' or not high < abs(number) <= 1e3 * high:
        return ''
    return f'; is it in mm, cm or inches? {number:g} mm are {1e-3 * number:g} m'


def _shots(path: Path, sights: Sights, ignored: list[str]) -> Iterator[RecordedShot]:
    for name, balls in sights.items():
        tracks = {ball: _track(rows) for ball, rows in balls.items()}
        doubled = sum(map(len, balls.values())) - sum(len(each.time) for each in tracks.values())
        if doubled:
            ignored.append(f'shot {name!r}: {doubled} lines with the time of another one')
        if not tracks:
            ignored.append(f'shot {name!r}: no ball was detected')
            continue
        length = _length(tracks.values())
        if length > LONGEST_SHOT:
            hint = '; is it in ms?' if length > 1e3 else ''
            raise ValueError(
                f'{path}: shot {name!r}: time must be within {LONGEST_SHOT:g} s of the first, got '
                f'{length:g} s{hint}'
            )
        yield RecordedShot(name, tracks)


def _track(rows: list[tuple[float, float, float, float]]) -> Track:
    """Sort the sights of a ball; of those with the same time, take the first."""
    columns = np.array(rows)
    time, first = np.unique(columns[:, 0], return_index=True)
    return Track(time, columns[first, 1:3], columns[first, 3])


def _length(tracks: Iterable[Track]) -> float:
    times = np.concatenate([each.time for each in tracks])
    return float(np.ptp(times))
