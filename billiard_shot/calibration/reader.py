"""
Recordings and strokes from files.

A recording in CSV has a line for each sight of a ball, with the header `shot,time,ball,x,y`. Times
are in s, places in m, in the frame `table` unless the description of the recording states another
one. Further columns: `sigma`, the standard deviation of x and y [m], and `z` [m]. A line whose x
or y is empty or NaN is a ball that was not detected. Lines may come in any order, and at any rate.

A recording in JSON has the form of the repository tailuge/billiards (dist/fit): a list of shots,
with `id`, and `balls`, which has `t` [s], `x` and `y` [m] of each ball. A sample follows the one
before only after a movement, so that a ball at rest has few of them.

Strokes in CSV have a line each. The header names the commanded and measured numbers: `a`, `b`
(ball radii), `elevation_deg`, `azimuth_deg` (degrees), `speed` (m/s), each together with the same
name after `measured_`. Numbers that were not measured are left out. A column `stroke` may name the
strokes.
"""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from collections.abc import Iterator, Mapping, Sequence
import csv
import dataclasses
from dataclasses import dataclass, replace
import json
import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.calibration.recording import (
    Floats,
    Frame,
    RecordedShot,
    Recording,
    Track,
    with_sigma,
)
from billiard_shot.numerics.vectors import wrapped
from billiard_shot.scene import fields, Noise
from billiard_shot.scene.errors import (
    InputError,
    Mistake,
    MOST_MISTAKES,
    must_be,
    reason,
    refused,
    unknown,
)
from billiard_shot.scene.fields import CheckedRecord, read
from billiard_shot.scene.files import read_document
from billiard_shot.scene.player import A, AZIMUTH, B, IN_DEGREES
from billiard_shot.shot.stroke import Stroke, stroke_from

Recordings = Recording | str | Path | Sequence[Recording | str | Path]

MOST_BYTES = 2**28
"""Largest size of a file: some five million lines."""

LONGEST_SHOT = 120.0
"""Longest time from the first to the last sight of a shot [s]."""

MOST_ELSEWHERE = 0.2
"""If more of the places are out of their bounds, the whole file has another unit."""

UNITS = ((400.0, 1e-3, 'mm or pixels'), (80.0, 1e-2, 'cm'), (10.0, 1e-2, 'cm or inches'))
"""Likely units of places that reach farther than a number: lengths [m] and names."""

LEAST_MOVEMENT = 3e-3
"""Between samples of a ball in JSON that lie nearer to each other, the ball was at rest [m]."""

REST_PERIOD = 0.1
"""Time between samples that stand for a ball at rest [s]."""


class CsvColumn(NamedTuple):
    """A column of a table: bounds and unit of its numbers, and whether a cell may be empty."""

    low: float
    high: float
    unit: str
    optional: bool = False


NAMES = 'shot', 'ball'
SIGHTS = {
    'time': CsvColumn(-1e7, 1e7, 's'),
    'x': CsvColumn(-10.0, 10.0, 'm', optional=True),
    'y': CsvColumn(-10.0, 10.0, 'm', optional=True),
    'sigma': CsvColumn(1e-6, 0.1, 'm', optional=True),
    'z': CsvColumn(-1.0, 10.0, 'm', optional=True),
}
NEEDED = 'shot', 'time', 'ball', 'x', 'y'
WRITTEN = *NEEDED, 'sigma'

MEASURED = 'measured_'
RANGES = {
    'a': CsvColumn(-1.0, 1.0, 'ball radii'),
    'b': CsvColumn(-1.0, 1.0, 'ball radii'),
    'elevation_deg': CsvColumn(-90.0, 90.0, 'degrees'),
    'azimuth_deg': CsvColumn(-360.0, 360.0, 'degrees'),
    'speed': CsvColumn(0.0, 50.0, 'm/s'),
}


class CsvTable(NamedTuple):
    """Columns of a file: names (n,), and numbers (n,), NaN where a cell is empty."""

    names: Mapping[str, list[str]]
    numbers: Mapping[str, Floats]


def read_table(
    path: Path,
    names: tuple[str, ...],
    columns: Mapping[str, CsvColumn],
    needed: tuple[str, ...] = (),
) -> CsvTable:
    """
    Read a file in CSV.

    Parameters
    ----------
    path : Path
    names : tuple of str
        Columns of names.
    columns : mapping of str to CsvColumn
        Columns of numbers.
    needed : tuple of str
        Columns that the header must have.

    Raises
    ------
    ValueError
        Naming the file, the lines and the fields that make no sense.

    """
    mistakes: list[Mistake] = []
    lines: list[list[str]] = []
    numbers: list[int] = []  # of the lines
    try:
        with path.open(encoding='utf-8-sig', newline='') as file:
            _check_size(path)
            rows = csv.reader(file)
            header = [word.strip() for word in next(rows, [])]
            mistakes += _mistakes_of_header(header, [*names, *columns], needed)
            for row in rows if not mistakes else ():
                if len(row) == len(header):
                    lines.append(row)
                    numbers.append(rows.line_num)
                elif row:
                    text = must_be(f'{len(header)} fields, as in the header', row)
                    mistakes.append(Mistake((), f'a line {text}', rows.line_num))
                if len(mistakes) > MOST_MISTAKES:
                    break
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f'{path}: must be a text in CSV ({error})') from None
    cells = dict(zip(header, zip(*lines, strict=True), strict=False))
    found = {name: np.array([_number(cell) for cell in cells.get(name, ())]) for name in columns}
    _check_unit(path, found, columns)
    for name in [name for name in names if name in cells]:
        wrong = [k for k, cell in enumerate(cells[name]) if not fields.fits_name(cell.strip())]
        mistakes += [
            Mistake((name,), must_be(fields.A_NAME, cells[name][k]), numbers[k]) for k in wrong
        ]
    for name, column in columns.items():
        outside = ~((found[name] >= column.low) & (found[name] <= column.high))
        if column.optional:
            outside &= ~np.isnan(found[name])
        allowed = f'a number from {column.low:g} to {column.high:g}'
        mistakes += [
            Mistake((name,), must_be(allowed, cells[name][k], column.unit), numbers[k])
            for k in np.flatnonzero(outside)[: MOST_MISTAKES + 1].tolist()
        ]
    if mistakes:
        mistakes.sort(key=lambda mistake: mistake.line or 0)
        raise InputError(mistakes[: MOST_MISTAKES + 1], str(path))
    kept = {name: [cell.strip() for cell in cells.get(name, ())] for name in names}
    return CsvTable(kept, {name: found[name] for name in columns if name in header})


def _check_size(path: Path) -> None:
    """Raise a ValueError if a file is too large to be read at once."""
    if (size := path.stat().st_size) > MOST_BYTES:
        raise ValueError(
            f'{path}: must have at most {MOST_BYTES} bytes, got {size}; divide it by shots'
        )


def _mistakes_of_header(
    header: list[str], known: list[str], needed: tuple[str, ...]
) -> Iterator[Mistake]:
    for separator, name in ((';', 'semicolons'), ('\t', 'tabs')):
        if separator in ''.join(header):
            yield Mistake((), f'fields must be separated by commas, got {name}', 1)
            return
    for word in needed:
        if word not in header:
            yield Mistake((word,), f'is missing in the header; it must be {",".join(needed)}', 1)
    for word in header:
        if word not in known:
            yield Mistake((word,), unknown(word, known), 1)
        elif header.count(word) > 1:
            yield Mistake((word,), 'is there twice', 1)


def _number(text: str) -> float:
    """Read a number; NaN if it is empty or NaN, infinite if it is something else."""
    try:
        return float(text or 'nan')
    except ValueError:
        return math.inf if text.strip() else math.nan


def _check_unit(path: Path, found: Mapping[str, Floats], columns: Mapping[str, CsvColumn]) -> None:
    """Raise ValueError if the places of the whole file are in another unit."""
    if 'x' not in columns:
        return
    places = np.abs(np.concatenate([found['x'], found['y']]))
    places = places[np.isfinite(places)]
    if not len(places) or np.mean(places > SIGHTS['x'].high) < MOST_ELSEWHERE:
        return
    most = float(np.quantile(places, 0.99))
    unit, length = next(((name, length) for least, length, name in UNITS if most > least))
    raise ValueError(
        f'{path}: x and y must be in m, got values to {most:.4g}; are they in {unit}? {most:.4g} '
        f'{unit.split()[0]} are {most * length:.3g} m'
    )


def read_csv(path: Path) -> Recording:
    """
    Read the shots of a recording; samples of which no line states a deviation have none.

    Raises
    ------
    ValueError
        Naming the file, the lines and the fields that make no sense.

    """
    table = read_table(path, NAMES, SIGHTS, NEEDED)
    if not len(table.numbers['time']):
        raise ValueError(f'{path}: must have a line for each sight of a ball, got none')
    columns = [table.numbers[name] for name in ('time', 'x', 'y')]
    columns.append(table.numbers.get('sigma', np.full(len(columns[0]), np.nan)))
    rows = np.stack(columns, axis=-1)
    seen = ~np.isnan(rows[:, 1] + rows[:, 2])
    sights: dict[str, dict[str, list[int]]] = {}
    for k, (shot, ball) in enumerate(zip(*table.names.values(), strict=True)):
        balls = sights.setdefault(shot, {})
        if seen[k]:
            balls.setdefault(ball, []).append(k)
    lost = int((~seen).sum())
    ignored = [f'{lost} lines without x or y: the balls were not detected'] if lost else []
    shots = tuple(_shots(path, sights, rows, ignored))
    return Recording(str(path), shots, ignored=tuple(ignored))


def _shots(
    path: Path, sights: dict[str, dict[str, list[int]]], rows: Floats, ignored: list[str]
) -> Iterator[RecordedShot]:
    for shot, balls in sights.items():
        tracks = {ball: _track(rows[numbers]) for ball, numbers in balls.items()}
        doubled = sum(map(len, balls.values())) - sum(len(each.time) for each in tracks.values())
        if doubled:
            ignored.append(f'shot {shot!r}: {doubled} lines with the time of another one')
        if not tracks:
            ignored.append(f'shot {shot!r}: no ball was detected')
            continue
        length = float(np.ptp(np.concatenate([each.time for each in tracks.values()])))
        if length > LONGEST_SHOT:
            hint = '; is it in ms?' if length > 1e3 else ''
            raise ValueError(
                f'{path}: shot {shot!r}: time must be within {LONGEST_SHOT:g} s of the first, got '
                f'{length:g} s{hint}'
            )
        yield RecordedShot(shot, tracks)


def _track(rows: Floats) -> Track:
    """Sort the sights of a ball; of those with the same time, take the first."""
    time, first = np.unique(rows[:, 0], return_index=True)
    return Track(time, rows[first, 1:3], rows[first, 3])


def write_csv(recording: Recording, path: Path) -> None:
    """Write the shots of a recording."""
    with path.open('w', encoding='utf-8', newline='') as file:
        writer = csv.writer(file)
        writer.writerow(WRITTEN)
        for shot in recording.shots:
            for ball, track in shot.tracks.items():
                columns = track.time.tolist(), track.place.tolist(), track.sigma.tolist()
                for time, (x, y), sigma in zip(*columns, strict=True):
                    places = f'{time:.6g}', ball, f'{x:.6g}', f'{y:.6g}'
                    writer.writerow([shot.name, *places, f'{sigma:.6g}'])


def read_carom_json(path: Path) -> Recording:
    """
    Read a file in JSON; the ball whose second sample comes first was struck.

    Raises
    ------
    ValueError
        Naming the file and the shot, if it is not of this kind.

    """
    try:
        _check_size(path)
        listed = json.loads(path.read_text(encoding='utf-8'))
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from None
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f'{path}: must be a text in JSON ({error})') from None
    if not isinstance(listed, list):
        raise ValueError(f'{path}: must be a list of shots')
    shots = []
    for number, shot in enumerate(listed):
        try:
            tracks = {str(ball): _with_rests(rows) for ball, rows in shot['balls'].items()}
            shots.append(RecordedShot(str(shot['id']), tracks))
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise ValueError(
                f'{path}: shot {number}: must have id, and t, x and y of each of its balls '
                f'({type(error).__name__}: {error})'
            ) from None
    return Recording(str(path), tuple(shots))


def _with_rests(listed: Any) -> Track:
    """Return the track of a ball, with samples added while the ball was at rest."""
    rows = np.stack([np.array(listed[key], float) for key in ('t', 'x', 'y')], axis=-1)
    rows = rows[np.isfinite(rows).all(axis=1)]
    if not len(rows):
        raise ValueError('a ball without samples')
    rows = rows[np.unique(rows[:, 0], return_index=True)[1]]
    rests = np.flatnonzero(np.linalg.norm(np.diff(rows[:, 1:], axis=0), axis=1) < LEAST_MOVEMENT)
    parts = [rows]
    for k in rests.tolist():
        times = np.arange(rows[k, 0] + REST_PERIOD, rows[k + 1, 0], REST_PERIOD)
        parts.append(np.column_stack([times, np.repeat(rows[k : k + 1, 1:], len(times), axis=0)]))
    rows = np.concatenate(parts)
    rows = rows[np.argsort(rows[:, 0], kind='stable')]
    return Track(rows[:, 0], rows[:, 1:], np.full(len(rows), np.nan))


def _texts(value: object) -> Mapping[str, str]:
    if not isinstance(value, Mapping):
        raise refused(value, 'a mapping of names in the recording to names of balls')
    return {str(key): str(each) for key, each in value.items()}


def _strokes(value: object) -> Mapping[str, Stroke]:
    if not isinstance(value, Mapping):
        raise refused(value, 'a mapping of shots to strokes, such as {1: {a: 0.2, speed: 1.5}}')
    return {
        str(key): each if isinstance(each, Stroke) else stroke_from(each, (0.0, 0.0, 0.0))
        for key, each in value.items()
    }


def _field(convert: Any, default: Any) -> Any:
    return dataclasses.field(default_factory=lambda: default, metadata={fields.TAKES: convert})


@dataclass(frozen=True, slots=True)
class _Frame(CheckedRecord):
    """As `Frame`, but in degrees, which people type."""

    x: float = fields.number('m', default=0.0)
    y: float = fields.number('m', default=0.0)
    angle_deg: float = fields.number('degrees', minimum=-360.0, maximum=360.0, default=0.0)
    scale: float = fields.number('', above=0.0, default=1.0)
    rate: float = fields.number('', above=0.0, default=1.0)


@dataclass(frozen=True, slots=True)
class RecordingDescription(CheckedRecord):
    """
    The description of a recording: the content of a YAML file of its name, beside it.

    Parameters
    ----------
    scene : str, optional
        Name or path of the scene with which a calibration begins.
    struck : str, optional
        The ball that the cue hits in all shots; by default the one that moves first.
    balls : mapping of str to str
        Names of balls by those that the recording has.
    sigma : float, optional
        Standard deviation of x and y, if the recording states none [m]; by default, the measured
        one, and at least 1 mm.
    frame : section
        As `Frame`, with the angle in degrees: `angle_deg`.
    strokes : mapping
        Commanded or measured strokes by the names of shots, as in files of strokes.
    noise : section, optional
        Errors with which the commanded strokes were played, as in scenes; see `RecordedShot`.

    """

    scene: str | None = _field(lambda value: None if value is None else str(value), None)
    struck: str | None = fields.name(nullable=True)
    balls: Mapping[str, str] = _field(_texts, {})
    sigma: float | None = fields.number('m', above=0.0, maximum=0.1, nullable=True)
    frame: _Frame = fields.section(_Frame, optional=True)
    strokes: Mapping[str, Stroke] = _field(_strokes, {})
    noise: Noise | None = fields.section(Noise, nullable=True)


def read_recording(path: str | Path) -> Recording:
    """
    Read a recording, and the description beside it.

    If neither states the standard deviation of places, it is measured, see `with_sigma`.

    Parameters
    ----------
    path : str or Path
        A file .csv or .json, see reader.py. A file of the same name that ends in .yaml is its
        `RecordingDescription`.

    Raises
    ------
    ValueError
        Naming the file, the line and the field of what is wrong.

    """
    path = Path(path)
    about = _description(path.with_suffix('.yaml'))
    if path.suffix == '.csv':
        recording = read_csv(path)
    elif path.suffix == '.json':
        recording = read_carom_json(path)
    else:
        raise ValueError(f'a recording {must_be("a file .csv or .json", str(path))}')
    if absent := about.strokes.keys() - {shot.name for shot in recording.shots}:
        raise ValueError(f'{path.with_suffix(".yaml")}: strokes: no shot {min(absent)!r}')
    seen = about.frame
    frame = Frame(seen.x, seen.y, math.radians(seen.angle_deg), seen.scale, seen.rate)
    shots = tuple(_named(shot, about) for shot in recording.shots)
    recording = replace(recording, shots=shots, frame=frame, scene=about.scene)
    return with_sigma(recording, about.sigma)


def read_recordings(recordings: Recordings) -> list[Recording]:
    """Read recordings; ValueError names the file, line and field of what is wrong."""
    if isinstance(recordings, Recording | str | Path):
        recordings = [recordings]
    read = [
        with_sigma(each, None) if isinstance(each, Recording) else read_recording(each)
        for each in recordings
    ]
    if not read:
        raise refused(recordings, 'at least one recording', 'recordings')
    return read


def _description(path: Path) -> RecordingDescription:
    if not path.exists():
        return RecordingDescription()
    document = read_document(path)
    mistakes = list(document.mistakes)
    try:
        found = read(RecordingDescription, document.data or {})
    except InputError as error:
        mistakes += error.mistakes
    if mistakes:
        raise InputError(mistakes, str(path), document.lines)
    return found


def _named(shot: RecordedShot, about: RecordingDescription) -> RecordedShot:
    """Name the balls of a shot, and add its struck ball and its stroke with errors."""
    tracks = {about.balls.get(ball, ball): track for ball, track in shot.tracks.items()}
    if len(tracks) < len(shot.tracks):
        raise ValueError(f'balls: shot {shot.name!r} has two balls with the same name')
    return RecordedShot(shot.name, tracks, about.struck, about.strokes.get(shot.name), about.noise)


def read_errors(path: Path, ball_radius: float) -> Floats:
    """
    Read errors of strokes, measured minus commanded.

    Parameters
    ----------
    path : Path
    ball_radius : float
        [m]

    Returns
    -------
    (strokes, 5) float array
        Of a, b [m], elevation, azimuth [degrees] and speed [m/s]; columns that were not measured
        are NaN.

    Raises
    ------
    ValueError
        Naming the file, the lines and the fields that make no sense.

    """
    both = RANGES | {MEASURED + name: column for name, column in RANGES.items()}
    numbers = read_table(path, ('stroke',), both).numbers
    if not numbers:
        raise ValueError(
            f'{path}: line 1: a header must have columns such as speed,measured_speed'
        )
    for word in numbers:
        other = word.removeprefix(MEASURED) if word.startswith(MEASURED) else MEASURED + word
        if other not in numbers:
            raise InputError([Mistake((word,), f'needs the column {other}', 1)], str(path))
    errors = np.full((len(next(iter(numbers.values()))), len(IN_DEGREES)), np.nan)
    for k, name in enumerate(IN_DEGREES):
        if name in numbers:
            errors[:, k] = numbers[MEASURED + name] - numbers[name]
    errors[:, AZIMUTH] = np.degrees(wrapped(np.radians(errors[:, AZIMUTH])))
    errors[:, [A, B]] *= ball_radius
    return errors
