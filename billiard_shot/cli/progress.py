"""A progress bar on stderr, shown only if stderr is a terminal."""

from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
import sys
from time import monotonic
from typing import TypeVar

from billiard_shot import machine_code, predict, Scene, Stroke

T = TypeVar('T')

BAR_WIDTH = 30  # characters of the bar itself
INTERVAL = 0.1  # s, shortest time between drawings
SAY_AFTER = 5.0  # s until the second line if stderr is not a terminal; then twice as long each


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
def reporting(label: str, total: int) -> Iterator[Callable[[int], None]]:
    """
    Show a bar while the block runs, for work that reports through a callback.

    Yields
    ------
    callable
        Function of the number of items done so far. It may be called at any rate, and draws at
        most ten times a second.

    """
    if not sys.stderr.isatty():
        yield lambda done: None
        return
    begin = last = monotonic()

    def report(done: int) -> None:
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


def estimate_without_machine_code(strokes: int, scene: Scene) -> None:
    """Without machine code, say on stderr how long the prediction of so many strokes may take."""
    if machine_code.available():
        return
    stroke = Stroke.from_offsets(elevation_deg=10.0, speed=2.0)
    begin = monotonic()
    predict(scene, stroke)
    minutes = strokes * (monotonic() - begin) / 60.0
    if minutes > 1.0:
        print(
            f'without numba, {strokes} strokes may take {minutes:.0f} minutes; a smaller --budget '
            'takes less',
            file=sys.stderr,
            flush=True,
        )


def wait_for_machine_code() -> bool:
    """
    Wait, with a bar, until the library is compiled; return whether it runs as machine code.

    If stderr is not a terminal, a line every few seconds reports the progress instead.
    """
    if not machine_code.available() or machine_code.is_complete():
        return machine_code.require()
    told = 0.0  # s after which the last line was printed
    terminal = sys.stderr.isatty()

    def report(done: int, total: int, waited: float) -> None:
        nonlocal told
        if terminal:
            text = f'compiling, once for this version: {done} of {total} parts, {waited:.0f} s'
            _draw(text + (' (usually less than a minute)' if waited < 60.0 else ''))
        elif not told or waited >= 2.0 * told:  # after 5, 10, 20, 40 s ...
            told = max(waited, SAY_AFTER)
            print(
                f'compiling, once for this version: {done} of {total} parts after {waited:.0f} s',
                file=sys.stderr,
                flush=True,
            )

    try:
        return machine_code.require(report)
    finally:
        if terminal:
            _draw('')
