"""
Commanded and measured strokes as CSV, a line for each stroke.

The header names the commanded and measured numbers: `a`, `b` (ball radii), `elevation_deg`,
`azimuth_deg` (degrees), `speed` (m/s), each together with the same name after `measured_`. Numbers
that were not measured are left out. A column `stroke` may name the strokes.
"""

from collections.abc import Iterator
import csv
from pathlib import Path

import numpy as np

from billiard_shot.calibration.csv_file import opened
from billiard_shot.calibration.recording import Floats
from billiard_shot.numerics.angles import wrapped
from billiard_shot.scene.errors import InputError, Mistake, must_be, unknown
from billiard_shot.scene.player import A, AZIMUTH, B, IN_DEGREES

MEASURED = 'measured_'
RANGES = {  # bounds and unit
    'a': (-1.0, 1.0, 'ball radii'),
    'b': (-1.0, 1.0, 'ball radii'),
    'elevation_deg': (-90.0, 90.0, 'degrees'),
    'azimuth_deg': (-360.0, 360.0, 'degrees'),
    'speed': (0.0, 50.0, 'm/s'),
}


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
    with opened(path) as file:
        rows = csv.reader(file)
        header = [word.strip() for word in next(rows, [])]
        mistakes = list(_mistakes_of_header(header))
        lines = []
        for row in rows if not mistakes else ():
            if row:
                line, wrong = _errors_in(header, row)
                lines.append(line)
                mistakes += [each._replace(line=rows.line_num) for each in wrong]
    if mistakes:
        raise InputError(mistakes, str(path))
    errors = np.reshape(np.array(lines, float), (-1, len(IN_DEGREES)))
    errors[:, AZIMUTH] = np.degrees(wrapped(np.radians(errors[:, AZIMUTH])))
    errors[:, [A, B]] *= ball_radius
    return errors


def _mistakes_of_header(header: list[str]) -> Iterator[Mistake]:
    known = ['stroke', *IN_DEGREES, *(MEASURED + name for name in IN_DEGREES)]
    for word in header:
        other = word.removeprefix(MEASURED) if word.startswith(MEASURED) else MEASURED + word
        if word not in known:
            yield Mistake((word,), unknown(word, known), 1)
        elif header.count(word) > 1:
            yield Mistake((word,), 'is there twice', 1)
        elif word != 'stroke' and other not in header:
            yield Mistake((word,), f'needs the column {other}', 1)
    if not set(header) & set(IN_DEGREES):
        yield Mistake((), f'a header must have columns such as speed,{MEASURED}speed', 1)


def _errors_in(header: list[str], row: list[str]) -> tuple[list[float], list[Mistake]]:
    """Return the errors (5,) of a line, and its mistakes."""
    if len(row) != len(header):
        text = must_be(f'{len(header)} fields, as in the header', row)
        return [], [Mistake((), f'a line {text}')]
    given, errors, mistakes = dict(zip(header, row, strict=True)), [], []
    for name in IN_DEGREES:
        low, high, unit = RANGES[name]
        numbers = []
        for word in (name, MEASURED + name):
            numbers.append(_number(given.get(word, '')))
            if word in given and not low <= numbers[-1] <= high:
                allowed = f'a number from {low:g} to {high:g}'
                mistakes.append(Mistake((word,), must_be(allowed, given[word], unit)))
        errors.append(numbers[1] - numbers[0])
    return errors, mistakes


def _number(text: str) -> float:
    """Read a number; NaN if it is something else."""
    try:
        return float(text)
    except ValueError:
        return np.nan
