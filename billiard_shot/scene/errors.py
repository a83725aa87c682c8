"""Mistakes in user input, each with its place; one error reports all of them."""

from collections.abc import Iterable, Iterator, Mapping
import difflib
from typing import Any, NamedTuple

Path = tuple[str, ...]  # keys from the top down, such as ('ball', 'mass')
TWICE = 'is there twice'
Lines = Mapping[Path, int]  # line of each key of a file, from 1


class Mistake(NamedTuple):
    """A mistake in one value: its path, and a text that follows the path."""

    path: Path
    text: str
    line: int | None = None  # in its file, if it is not the line of the path

    def below(self, *keys: str) -> 'Mistake':
        """Return the mistake for a mapping that is itself at `keys`."""
        return self._replace(path=(*keys, *self.path))


class InputError(ValueError):
    """
    A ValueError whose text has one line for each mistake.

    Parameters
    ----------
    mistakes : iterable of Mistake
        At least one.
    about : str
        Name of the input, such as 'scene' or a file.
    lines : mapping of path to int, optional
        Lines of the keys of a file; the mistakes are then sorted by line.
    valid_part : optional
        The valid part of a value that is only partly wrong.

    """

    def __init__(
        self,
        mistakes: Iterable[Mistake],
        about: str = '',
        lines: Lines | None = None,
        valid_part: Any = None,
    ) -> None:
        found = tuple(mistakes)
        if lines is not None:
            found = tuple(m._replace(line=m.line or _line(m.path, lines)) for m in found)
            found = tuple(sorted(found, key=lambda mistake: mistake.line or 0))
        super().__init__(found, about)
        self.mistakes, self.about, self.valid_part = found, about, valid_part

    def __str__(self) -> str:
        texts = [_text(mistake) for mistake in self.mistakes]
        if len(texts) == 1:
            return f'{self.about}: {texts[0]}' if self.about else texts[0]
        heading = f'{len(texts)} mistakes'
        return '\n  '.join([f'{self.about}: {heading}' if self.about else heading, *texts])


def refused(value: object, allowed: str, about: str = '') -> InputError:
    """Make the error for a value that is not allowed; `about` names the value."""
    return InputError([Mistake((), f'{value!r} is not allowed; it must be {allowed}')], about)


def unknown(key: str, known: Iterable[str]) -> str:
    """Text about an unknown key, with the nearest known key and a list of all."""
    names = list(known)
    nearest = difflib.get_close_matches(key, names, 1, 0.0)[0]
    return f'unknown key; the nearest known one is {nearest} (of {", ".join(names)})'


def found_in(error: ValueError, *keys: str) -> Iterator[Mistake]:
    """Yield the mistakes of an error, placed below `keys`."""
    if isinstance(error, InputError):
        yield from (mistake.below(*keys) for mistake in error.mistakes)
    else:
        yield Mistake(keys, str(error))


def _text(mistake: Mistake) -> str:
    place = f'line {mistake.line}: ' if mistake.line else ''
    return (
        f'{place}{".".join(mistake.path)}: {mistake.text}'
        if mistake.path
        else (f'{place}{mistake.text}')
    )


def _line(path: Path, lines: Lines) -> int | None:
    """Line of a key or, if the key is missing, of the mapping in which it is missing."""
    for length in range(len(path), -1, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return None
