"""
Mistakes in user input, each with its place; one error reports all of them.

The messages have one form: 'FIELD must be ALLOWED, got VALUE (unit)'. If a name is unknown, the
message adds the nearest known one.
"""

from collections.abc import Iterable, Iterator, Mapping
import difflib
from typing import Any, NamedTuple

Path = tuple[str, ...]  # keys from the top down, such as ('ball', 'mass')
TWICE = 'is there twice'
LONGEST_VALUE = 200  # characters of a value in a message
MOST_MISTAKES = 50  # in a message
Lines = Mapping[Path, int]  # line of each key of a file, from 1


class Mistake(NamedTuple):
    """
    A mistake in one value: its path, and a text that says what is wrong there.

    The text continues the sentence that the path begins, such as 'must be above 0, got -1'. A text
    that is a sentence itself begins with a colon.
    """

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
        texts = [_text(mistake) for mistake in self.mistakes[:MOST_MISTAKES]]
        if len(self.mistakes) == 1:
            colon = ':' if self.mistakes[0].path or self.mistakes[0].line else ''
            return f'{self.about}{colon} {texts[0]}' if self.about else texts[0]
        heading = f'{len(self.mistakes)} mistakes'
        texts += ['...'] * (len(self.mistakes) > MOST_MISTAKES)
        return '\n  '.join([f'{self.about}: {heading}' if self.about else heading, *texts])


def printable(text: str) -> str:
    """Escape characters that do not print; a terminal would obey some of them."""
    return ''.join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def must_be(allowed: str, got: object, unit: str = '') -> str:
    """Text of a mistake: the allowed values, and the start of the `repr` of the given one."""
    text = repr(got)
    if len(text) > LONGEST_VALUE:
        text = f'{text[:LONGEST_VALUE]} ...'
    return f'must be {allowed}, got {text}' + (f' ({unit})' if unit else '')


def must_be_one_of(known: Iterable[object], got: object, what: str = '') -> str:
    """Text about a value that is none of the known ones, with the nearest of them."""
    names = [str(name) or repr(name) for name in known]
    if not names:
        return f'must name a {what or "value"}, but there is none, got {got!r}'
    text = must_be(f'one of {", ".join(names)}', got)
    return text + suggestion(names, got) if len(names) > 1 else text


def suggestion(known: Iterable[object], got: object) -> str:
    """Text that adds the known name nearest to the given one; '' if none is near."""
    near = difflib.get_close_matches(str(got), [str(name) for name in known], 1)
    return f'; the nearest is {near[0]}' if near else ''


def refused(
    value: object, allowed: str, name: str = '', unit: str = '', hint: str = ''
) -> InputError:
    """Make the error for a value that is not allowed; `hint` is the end of its text."""
    return InputError([Mistake((name,) if name else (), must_be(allowed, value, unit) + hint)])


def unknown(key: str, known: Iterable[str]) -> str:
    """Text about an unknown key, with the nearest known key and a list of all."""
    names = list(known)
    nearest = difflib.get_close_matches(key, names, 1, 0.0)[0]
    return f'is unknown; the nearest key is {nearest} (of {", ".join(names)})'


def found_in(error: ValueError, *keys: str) -> Iterator[Mistake]:
    """Yield the mistakes of an error, placed below `keys`."""
    if isinstance(error, InputError):
        yield from (mistake.below(*keys) for mistake in error.mistakes)
    else:
        yield Mistake(keys, f': {error}' if keys else str(error))


def reason(error: Exception) -> str:
    """Say what an error says, without the number and the file that an OSError repeats."""
    return str(getattr(error, 'strerror', None) or error)


def _text(mistake: Mistake) -> str:
    place = f'line {mistake.line}: ' if mistake.line else ''
    if not mistake.path:
        return place + mistake.text
    space = '' if mistake.text.startswith(':') else ' '
    return f'{place}{printable(".".join(mistake.path))[:LONGEST_VALUE]}{space}{mistake.text}'


def _line(path: Path, lines: Lines) -> int | None:
    """Line of a key or, if the key is missing, of the mapping in which it is missing."""
    for length in range(len(path), -1, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return None
