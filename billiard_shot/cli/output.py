"""Output of commands: exit codes, text that is not lost, tables, progress, and Ctrl+C."""

import argparse
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Sized
from contextlib import contextmanager, redirect_stdout
import csv
from dataclasses import dataclass
import io
from itertools import chain
import json
import math
import os
import signal
import sys
import textwrap
from time import monotonic
from types import FrameType
from typing import Any, cast, ClassVar, TypeVar

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130

EXIT_CODES: Mapping[int, str] = {
    DONE: 'done',
    FAILED: 'no result, such as a refused stroke, no plan or a file with mistakes',
    WRONG_INPUT: 'wrong input',
    INTERRUPTED: 'interrupted by Ctrl+C',
}


class _Output:
    """A stream that discards its text from the time on at which its reader closes the pipe."""

    def __init__(self, stream: io.TextIOBase) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write text, or discard it."""
        encoding = self._stream.encoding or 'utf-8'
        try:
            return self._stream.write(text.encode(encoding, 'backslashreplace').decode(encoding))
        except BrokenPipeError:
            discard_output()
            return len(text)

    def flush(self) -> None:
        """Write all text that waits, or discard it."""
        try:
            self._stream.flush()
        except BrokenPipeError:
            discard_output()


@contextmanager
def tolerant_output() -> Iterator[None]:
    r"""
    Within the block, let no closed pipe and no character end the program.

    A command goes on if the reader of its output has ended, because it may have files to write. A
    character that the encoding does not have is written as its number, such as \xb0.
    """
    if sys.stdout is None:  # the shell has closed the output
        yield
        return
    with redirect_stdout(cast(io.TextIOBase, _Output(cast(io.TextIOBase, sys.stdout)))):
        yield
        sys.stdout.flush()


def discard_output() -> None:
    """Discard all later text, and the text that Python would write at exit."""
    if sys.__stdout__ is not None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.__stdout__.fileno())


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


@dataclass(frozen=True)
class OfFormat:
    """
    Formats for programs.

    Parameters
    ----------
    json : bool
        Print JSON, an object per line, in SI units.
    csv : bool
        Print CSV, in SI units.

    """

    EXCLUSIVE: ClassVar = True
    json: bool = False
    csv: bool = False


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


T = TypeVar('T')

BAR_WIDTH = 30  # characters of the bar itself
INTERVAL = 0.1  # s, shortest time between drawings


def progress(items: Iterable[T], label: str, total: int | None = None) -> Iterator[T]:
    """
    Iterate over `items` with a bar that shows how many are done.

    `total` is their number, for items without a length.
    """
    count = total if total is not None else len(items) if isinstance(items, Sized) else 0
    with reporting(label, count) as report:
        for done, item in enumerate(items, 1):
            yield item
            report(done)


@contextmanager
def reporting(label: str, total: int) -> Iterator[Callable[..., None]]:
    """
    Show a bar while the block runs, for work that reports through a callback.

    Yields
    ------
    callable
        Function of the number of items done so far and, if they change, label and total. It may
        be called at any rate, and draws at most ten times a second.

    """
    if not sys.stderr.isatty():
        yield lambda done, label='', total=0: None
        return
    begin = last = monotonic()

    def report(done: int, label: str = label, total: int = total) -> None:
        nonlocal last
        now = monotonic()
        if now - last >= INTERVAL:
            last = now
            _draw(progress_line(label, done, total, now - begin))

    _draw(progress_line(label, 0, total, 0.0))
    try:
        yield report
    finally:
        _draw('')


def progress_line(label: str, done: int, total: int, elapsed: float) -> str:
    """Text of a bar after `elapsed` seconds, with an estimate of the remaining time."""
    if total <= 0:
        return f'{label}: {done}'
    part = min(done / total, 1.0)
    filled = int(BAR_WIDTH * part)
    text = f'{label}: [{"#" * filled}{"." * (BAR_WIDTH - filled)}] {done}/{total}'
    return f'{text}, {elapsed * (1.0 / part - 1.0):.0f} s to go' if 0.0 < part < 1.0 else text


def _draw(text: str) -> None:
    sys.stderr.write(f'\r\033[K{text}')  # back to the start, clear the line
    sys.stderr.flush()


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """
    Let the first Ctrl+C in the block end a piece of work; the second one ends the program.

    Yields
    ------
    callable
        Whether Ctrl+C was pressed.

    """
    pressed = False

    def note(number: int, frame: FrameType | None) -> None:
        nonlocal pressed
        if pressed:
            raise KeyboardInterrupt
        pressed = True

    before = signal.signal(signal.SIGINT, note)
    try:
        yield lambda: pressed
    finally:
        signal.signal(signal.SIGINT, before)
