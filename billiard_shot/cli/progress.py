"""A progress bar on stderr, shown only if stderr is a terminal."""

from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
import sys
from time import monotonic
from typing import TypeVar

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
