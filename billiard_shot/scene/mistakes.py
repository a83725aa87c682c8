"""Mistakes in what people give: each with its place, all of them in one error."""

from collections.abc import Iterable, Iterator, Mapping
import difflib
from typing import Any, NamedTuple

Path = tuple[str, ...]  # keys from the top down, such as ('ball', 'mass')
TWICE = 'is there twice'
Lines = Mapping[Path, int]  # of a file: where each key stands, from 1


class Mistake(NamedTuple):
    """What is wrong with one value: where it is, and a sentence that goes on from that."""

    path: Path
    text: str
    line: int | None = None  # in its file, where that is not simply the line of the path

    def below(self, *keys: str) -> 'Mistake':
        """Place the same mistake in a mapping that is itself at `keys`."""
        return self._replace(path=(*keys, *self.path))


class InputError(ValueError):
    """
    A ValueError with every mistake in its text, each in a line of its own.

    Parameters
    ----------
    mistakes : iterable of Mistake
        At least one.
    about : str
        What they are mistakes in, such as 'scene' or a file.
    lines : mapping of path to int, optional
        Where things stand in the file; then the mistakes are in the order of their lines.
    rest : optional
        What is right of a value of which only parts are wrong.

    """

    def __init__(
        self,
        mistakes: Iterable[Mistake],
        about: str = '',
        lines: Lines | None = None,
        rest: Any = None,
    ) -> None:
        found = tuple(mistakes)
        if lines is not None:
            found = tuple(m._replace(line=m.line or _line(m.path, lines)) for m in found)
            found = tuple(sorted(found, key=lambda mistake: mistake.line or 0))
        super().__init__(found, about)
        self.mistakes, self.about, self.rest = found, about, rest

    def __str__(self) -> str:
        texts = [_text(mistake) for mistake in self.mistakes]
        if len(texts) == 1:
            return f'{self.about}: {texts[0]}' if self.about else texts[0]
        heading = f'{len(texts)} mistakes'
        return '\n  '.join([f'{self.about}: {heading}' if self.about else heading, *texts])


def refused(value: object, allowed: str) -> InputError:
    """Error for a value, with what it must be."""
    return InputError([Mistake((), f'{value!r} is not allowed; it must be {allowed}')])


def unknown(key: str, known: Iterable[str]) -> str:
    """Text about a key that nothing is known of, with the nearest one and all that there are."""
    names = list(known)
    nearest = difflib.get_close_matches(key, names, 1, 0.0)[0]
    return f'unknown key; the nearest known one is {nearest} (of {", ".join(names)})'


def found_in(error: ValueError, *keys: str) -> Iterator[Mistake]:
    """Go through the mistakes that an error tells of, placed below `keys`."""
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
    """Line of a key or, for one that is missing, of what it is missing in."""
    for length in range(len(path), -1, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return None
