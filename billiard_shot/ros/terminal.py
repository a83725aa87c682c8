"""What the programs print for the operator, and what the operator types."""

import os
import select
import sys
from typing import TextIO

from billiard_shot.scene.errors import printable

FIRE = 'fire'  # what the operator types to fire an aimed shot


def escaped(text: str) -> str:
    """Escape characters that a terminal would obey, except ends of lines."""
    return '\n'.join(map(printable, text.split('\n')))


def say(text: str, file: TextIO | None = None) -> None:
    """Print lines at once, escaped."""
    print(escaped(text), file=file, flush=True)


class TypedLines:
    """Lines that somebody types, while the program goes on."""

    def __init__(self) -> None:
        self._typed = b''

    def next(self) -> str | None:
        """Return the next line without spaces at its ends; None if there is none yet."""
        if b'\n' not in self._typed and select.select([sys.stdin], [], [], 0.0)[0]:
            self._typed += os.read(sys.stdin.fileno(), 4096)
        line, end, rest = self._typed.partition(b'\n')
        if not end:
            return None
        self._typed = rest
        return line.decode(errors='replace').strip()
