"""
Fields that know what they allow: dataclasses that check themselves and read themselves from YAML.

A field is declared with what it takes (`number`, `choice`, `yes_or_no`, `section` ...). `check`
makes a constructor refuse everything else; `read` does the same for a mapping, and finds every
mistake in it before it complains.
"""
from collections.abc import Callable, Mapping
import dataclasses
import difflib
import math
from numbers import Real
from typing import Any, TypeVar

S = TypeVar('S')
Convert = Callable[[object], Any]
_TAKES, _DERIVED = 'takes', 'derived'


def number(
    unit: str, *, above: float | None = None, least: float | None = None,
    most: float | None = None, default: float | None = None,
    derived: Callable[[Any], float] | None = None,
) -> Any:
    """
    Field for a finite number [unit] above, or from, and up to the given bounds.

    Without `default` it must be given, unless `derived` finds it from the other fields.
    """
    bounds = [f'{word} {bound:g}' for word, bound in (
        ('above', above), ('at least', least), ('at most', most)) if bound is not None]
    allowed = 'a finite number ' + ' and '.join(bounds) + (f' ({unit})' if unit else '')

    def convert(value: object) -> float:
        if isinstance(value, bool) or not isinstance(value, Real):
            raise ValueError(f'{value!r} is not allowed; it must be {allowed}')
        found = float(value)
        if (not math.isfinite(found) or (above is not None and found <= above)
                or (least is not None and found < least) or (most is not None and found > most)):
            raise ValueError(f'{value!r} is not allowed; it must be {allowed}')
        return found

    return _field(convert, dataclasses.MISSING if default is None else default, derived)


def choice(*options: str, default: str) -> Any:
    """Field for one of some words. YAML reads a bare on and off as true and false: they count."""

    def convert(value: object) -> str:
        if isinstance(value, bool):
            value = 'on' if value else 'off'
        if value not in options:
            raise ValueError(f'{value!r} is not allowed; it must be one of {", ".join(options)}')
        return str(value)

    return _field(convert, default)


def yes_or_no(*, default: bool) -> Any:
    """Field for true or false."""

    def convert(value: object) -> bool:
        if not isinstance(value, bool):
            raise ValueError(f'{value!r} is not allowed; it must be true or false')
        return value

    return _field(convert, default)


def places() -> Any:
    """Field for a mapping of names to points (x, y) on the table [m]."""
    coordinate = number('m').metadata[_TAKES]

    def convert(value: object) -> dict[str, tuple[float, float]]:
        if not isinstance(value, Mapping):
            raise ValueError(f'{value!r} is not allowed; it must be a mapping of names to [x, y]')
        found = {}
        for name, point in value.items():
            try:
                x, y = point
                found[str(name)] = coordinate(x), coordinate(y)
            except (TypeError, ValueError):
                raise ValueError(
                    f'{point!r} of {name!r} is not allowed; it must be two finite numbers, '
                    '[x, y] (m)'
                ) from None
        return found

    return dataclasses.field(default_factory=dict, hash=False, metadata={_TAKES: convert})


def section(kind: type[S], *, optional: bool = False, absent: bool = False) -> Any:
    """Field for a dataclass of such fields; `absent`: it need not be there, and then is None."""

    def convert(value: object) -> S | None:
        if not isinstance(value, kind) and not (absent and value is None):
            raise ValueError(f'{value!r} is not allowed; it must be a {kind.__name__}')
        return value

    factory: Any = (lambda: None) if absent else kind if optional else dataclasses.MISSING
    return dataclasses.field(default_factory=factory, metadata={_TAKES: convert, 'section': kind})


def check(instance: Any) -> None:
    """
    Convert and check every field of a frozen dataclass; for its `__post_init__`.

    Raises
    ------
    ValueError
        Naming each wrong field, its value and what is allowed.

    """
    mistakes = []
    derived = []
    for field in dataclasses.fields(instance):
        value = getattr(instance, field.name)
        if value is None and field.metadata.get(_DERIVED):
            derived.append(field)
            continue
        try:
            object.__setattr__(instance, field.name, field.metadata[_TAKES](value))
        except ValueError as mistake:
            mistakes.append(f'{field.name}: {mistake}')
    complain(mistakes)
    for field in derived:
        object.__setattr__(instance, field.name, field.metadata[_DERIVED](instance))


def read(kind: type[S], data: object, mistakes: list[str], path: str = '') -> S | None:
    """Read a dataclass of such fields from a mapping; None, and new `mistakes`, if it is wrong."""
    if not isinstance(data, Mapping):
        mistakes.append(f'{path or "scene"}: {data!r} is not allowed; it must be a mapping')
        return None
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    before = len(mistakes)
    values: dict[str, Any] = {}
    for key, value in data.items():
        where = f'{path}.{key}' if path else str(key)
        if key not in fields:
            mistakes.append(f'{where}: unknown key{_nearest(str(key), list(fields))}')
            continue
        metadata = fields[key].metadata
        try:
            if 'section' in metadata:
                values[key] = read(metadata['section'], value, mistakes, where)
            else:
                values[key] = metadata[_TAKES](value)
        except ValueError as mistake:
            mistakes.append(f'{where}: {mistake}')
    for name, field in fields.items():
        if (name not in data and field.default is dataclasses.MISSING
                and field.default_factory is dataclasses.MISSING):
            mistakes.append(f'{path}.{name}: missing' if path else f'{name}: missing')
    if len(mistakes) > before:
        return None
    try:
        return kind(**values)
    except ValueError as mistake:
        mistakes.append(f'{path}.{mistake}' if path else str(mistake))
        return None


def write(instance: Any) -> dict[str, Any]:
    """Plain dict from which `read` makes the same again."""
    result = {}
    for field in dataclasses.fields(instance):
        value = getattr(instance, field.name)
        if dataclasses.is_dataclass(value):
            value = write(value)
        elif isinstance(value, dict):
            value = {name: list(point) for name, point in value.items()}
        elif value is None or (field.metadata.get(_DERIVED) and value == math.inf):
            continue
        result[field.name] = value
    return result


def complain(mistakes: list[str], about: str = '') -> None:
    """Raise one ValueError with all mistakes, if there are any."""
    if len(mistakes) == 1:
        raise ValueError(f'{about}: {mistakes[0]}' if about else mistakes[0])
    if mistakes:
        heading = f'{about}: {len(mistakes)} mistakes' if about else f'{len(mistakes)} mistakes'
        raise ValueError('\n  '.join([heading, *mistakes]))


def _field(
    convert: Convert, default: Any, derived: Callable[[Any], float] | None = None
) -> Any:
    if derived:
        return dataclasses.field(default=None, metadata={_TAKES: convert, _DERIVED: derived})
    return dataclasses.field(default=default, metadata={_TAKES: convert})


def _nearest(key: str, known: list[str]) -> str:
    nearest = difflib.get_close_matches(key, known, 1, 0.0)[0]
    return f'; the nearest known one is {nearest} (of {", ".join(known)})'
