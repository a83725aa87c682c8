"""Standard output that loses no result if its pipe closes, or if it can only show ASCII."""

import codecs
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout
import io
import os
import sys
from typing import Any, cast
import unicodedata

ASCII: Mapping[str, str] = {
    '°': 'deg',
    'µ': 'u',
    'μ': 'u',
    '²': '^2',
    '±': '+/-',
    '−': '-',
    '–': '-',
    '·': '*',
    '×': 'x',
    '’': "'",
    '≤': '<=',
    '≥': '>=',
}
"""Replacements of characters that the encoding of the terminal does not have."""


class _Output:
    """A stream that discards its text from the time on at which its reader closes the pipe."""

    def __init__(self, stream: io.TextIOBase) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write text, or discard it."""
        try:
            return self._stream.write(text)
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
    """
    Within the block, let no closed pipe and no character end the program.

    A command goes on if the reader of its output has ended, because it may have files to write. A
    character that the encoding does not have is replaced (`ASCII`).
    """
    if sys.stdout is None:  # the shell has closed the output
        yield
        return
    before = [
        (stream, stream.errors)
        for stream in (sys.stdout, sys.stderr)
        if isinstance(stream, io.TextIOWrapper)
    ]
    for stream, _ in before:
        stream.reconfigure(errors=_in_ascii.__name__)
    try:
        with redirect_stdout(cast(io.TextIOBase, _Output(cast(io.TextIOBase, sys.stdout)))):
            yield
            sys.stdout.flush()
    finally:
        for stream, errors in before:
            stream.reconfigure(errors=errors)


def discard_output() -> None:
    """Discard all later text, and the text that Python would write at exit."""
    if sys.__stdout__ is not None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.__stdout__.fileno())


def _in_ascii(error: UnicodeError) -> tuple[str, int]:
    """Replace characters that an encoding does not have."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    wrong = error.object[error.start : error.end]
    plain = (ASCII.get(each) or unicodedata.normalize('NFKD', each) for each in wrong)
    text = ''.join(plain).encode('ascii', 'ignore').decode() or '?'
    return text, error.end


codecs.register_error(_in_ascii.__name__, _in_ascii)
