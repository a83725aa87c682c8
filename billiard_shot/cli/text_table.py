"""Tables of a command: text of at most 80 columns, CSV or JSON."""

import argparse
from collections.abc import Callable, Iterable, Mapping, Sequence
import csv
from dataclasses import dataclass
from itertools import chain
import json
import math
import sys
import textwrap
from typing import Any

WIDTH = 80  # characters of a line
LAST = 24  # characters: smallest width of the last column


@dataclass(frozen=True, slots=True)
class Column:
    """
    A column of a table.

    Attributes
    ----------
    key : str
        Name in CSV and JSON, where numbers are in SI units unless the name has another unit.
    head, unit : str
        Name in text, and the line below it. A column without `head` is not in the text.
    show : callable
        Formats a value as text.

    """

    key: str
    head: str = ''
    unit: str = ''
    show: Callable[[Any], str] = str


def add_format_arguments(parser: argparse.ArgumentParser) -> None:
    """Add --json and --csv."""
    formats = parser.add_mutually_exclusive_group()
    formats.add_argument(
        '--json', action='store_true', help='print JSON, an object per line, in SI units'
    )
    formats.add_argument('--csv', action='store_true', help='print CSV, in SI units')


def wants_text(options: argparse.Namespace) -> bool:
    """Whether to print text for people."""
    return not (options.json or options.csv)


def print_rows(
    columns: Sequence[Column],
    rows: Sequence[Mapping[str, Any]],
    options: argparse.Namespace,
    group: str = '',
) -> None:
    """
    Print rows in the format that the options select.

    In text, a column named `group` becomes a heading above the rows with the same value.
    """
    if options.json:
        for row in rows:
            print(json.dumps(_plain(row), allow_nan=False))
    elif options.csv:
        # Some columns combine others, and exist only in text.
        keys = [column.key for column in columns]
        print_csv(rows, [key for key in keys if not rows or key in rows[0]])
    else:
        shown = [column for column in columns if column.head]
        lines: list[Sequence[str]] = [[column.head for column in shown]]
        if any(column.unit for column in shown):
            lines.append([column.unit for column in shown])
        heading = None
        for row in rows:
            if group and row[group] != heading:
                heading = row[group]
                lines.append([str(heading)])
            cells = [column.show(row[column.key]) for column in shown]
            lines.append([f'  {cells[0]}', *cells[1:]] if group else cells)
        print(table(lines))


def print_footer(text: str, options: argparse.Namespace) -> None:
    """Print a paragraph below a table in text format; print nothing in other formats."""
    if wants_text(options):
        print()
        print(textwrap.fill(text, WIDTH))


def print_csv(rows: Iterable[Mapping[str, Any]], keys: Sequence[str]) -> None:
    """Print the values of some keys as CSV; a vector has a column for each of x, y and z."""
    flat = [dict(chain.from_iterable(_flat(key, row[key]) for key in keys)) for row in rows]
    writer = csv.DictWriter(sys.stdout, list(flat[0]) if flat else keys, lineterminator='\n')
    writer.writeheader()
    writer.writerows(flat)


def table(rows: Sequence[Sequence[str]]) -> str:
    """
    Format rows of cells as aligned columns, in lines of at most 80 characters.

    Long text in the last column goes on in the next line. A row with one cell is a heading.
    """
    full = [row for row in rows if len(row) > 1]
    widths = [max(map(len, column)) for column in zip(*full, strict=True)]
    room = max(WIDTH - sum(width + 2 for width in widths[:-1]), LAST)
    lines = []
    for row in rows:
        if len(row) == 1:
            lines += textwrap.wrap(row[0], WIDTH, subsequent_indent='  ')
            continue
        start = ''.join(f'{cell:{width}}  ' for cell, width in zip(row, widths[:-1], strict=False))
        last = [row[-1]] if len(row[-1]) <= room else textwrap.wrap(row[-1], room)
        lines.append((start + last[0]).rstrip())
        lines += [' ' * len(start) + rest for rest in last[1:]]
    return '\n'.join(lines)


def numbers(values: Iterable[float], digits: int) -> str:
    """Format numbers with `digits` digits after the decimal point, right-aligned."""
    # + 0.0 turns -0 into 0
    texts = (f'{round(value, digits) + 0.0:.{digits}f}' for value in values)
    return ' '.join(text.rjust(digits + 4) for text in texts)


def _flat(key: str, value: Any) -> list[tuple[str, Any]]:
    if key == 'interval':
        return list(zip(('low', 'high'), value, strict=True))
    if isinstance(value, Sequence) and 2 <= len(value) <= 3 and isinstance(value[0], float):
        return [(f'{key}_{axis}', each) for axis, each in zip('xyz', value, strict=False)]
    return [(key, value)]


def _plain(row: Mapping[str, Any]) -> dict[str, Any]:
    """Replace numbers that JSON cannot represent by None."""
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in row.items()
    }
