"""Ctrl+C during a search ends the search; the command goes on with its best result so far."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
import signal
from types import FrameType


@contextmanager
def interruptible() -> Iterator[Callable[[], bool]]:
    """
    Let the first Ctrl+C in the block end a search; the second one ends the program.

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
