"""
Fields with the values that they allow, and dataclasses that check themselves by them.

Such dataclasses are read from mappings, with all mistakes found at once.
"""

from collections.abc import Callable, Iterator, Mapping
import copy
import dataclasses
from inspect import cleandoc
import math
from numbers import Integral, Real
import re
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import errors

T = TypeVar('T')


class ByName(dict[str, T]):
    """Values by the names of balls; the error for a missing name tells which names there are."""

    def __missing__(self, name: str) -> T:
        raise KeyError(f'ball {errors.must_be_one_of(self, name, "ball")}')


LARGEST = 1e12
"""
Largest coordinate [m], speed [m/s] and spin [rad/s].

At this size rounding is as large as the tolerance of predictions, and powers do not overflow yet.
"""


def as_float(value: object) -> float:
    """Return a number as a float; infinite if it is too large, NaN if it is not a number."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.inf


def as_floats(values: object) -> NDArray[np.float64]:
    """Return numbers as an array of floats; an empty array if they are not numbers."""
    try:
        return np.ascontiguousarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        return np.empty(0)


def whole(name: str, value: object, minimum: int) -> int:
    """Return a whole number; raise ValueError for other values, or if it is below `minimum`."""
    if isinstance(value, bool) or not isinstance(value, Integral) or value < minimum:
        raise errors.refused(value, f'a whole number, at least {minimum}', name)
    return int(value)


def positive(name: str, value: object, unit: str) -> float:
    """Return a finite number above 0; raise ValueError for other values."""
    number = as_float(value)
    if not 0.0 < number < math.inf:
        raise errors.refused(value, 'finite and above 0', name, unit)
    return number


def one_or_many(value: object) -> tuple[Any, ...]:
    """Return the elements of a list, tuple or set (sorted as text); of another value, itself."""
    if isinstance(value, set | frozenset):
        return tuple(sorted(value, key=str))
    return tuple(value) if isinstance(value, tuple | list) else (value,)


def check_type(name: str, value: object, kind: type) -> None:
    """Raise ValueError if a value is of another type."""
    if not isinstance(value, kind):
        raise errors.refused(value, f'a {kind.__name__}', name)


Convert = Callable[[object], Any]
TAKES, DERIVED, SECTION_KEY, NAMED = 'takes', 'derived', 'section', 'named'
NO_NAMES: Mapping[str, Any] = {}
NUMBER, WHOLE = 'number', 'whole'
THOUSANDTHS = {'kg': 'g', 'm': 'mm', 's': 'ms'}
LONGEST_NAME = 64  # characters
A_NAME = f"a name, such as '8', of at most {LONGEST_NAME} printable characters"


class Range(NamedTuple):
    """The values that a number may have; None where there is no bound."""

    unit: str
    above: float | None
    minimum: float | None
    maximum: float | None


class DerivedNumber(float):
    """A number that was computed from other fields; arithmetic with it gives a float."""

    __slots__ = ()


def number(
    unit: str,
    *,
    above: float | None = None,
    minimum: float | None = None,
    maximum: float | None = None,
    default: float | None = None,
    derived: Callable[[Any], float] | None = None,
    nullable: bool = False,
) -> Any:
    """
    Field for a finite number [unit] within bounds.

    Without `default` the number is required, unless `derived` computes it from the other fields,
    or it is `nullable`. A nullable number is None if it is not given.
    """
    convert = _number_within(unit, above, minimum, maximum)
    metadata: dict[str, Any] = {
        TAKES: _or_none(convert) if nullable else convert,
        NUMBER: Range(unit, above, minimum, maximum),
    }
    if nullable:
        return dataclasses.field(default=None, metadata=metadata)
    if derived:
        return dataclasses.field(default=None, metadata=metadata | {DERIVED: derived})
    value = dataclasses.MISSING if default is None else default
    return dataclasses.field(default=value, metadata=metadata)


def whole_number(*, minimum: int, default: int | None, maximum: int | None = None) -> Any:
    """Field for an integer, at least `minimum` and at most `maximum`."""

    def convert(value: object) -> int:
        found = whole('', value, minimum)
        if maximum is not None and found > maximum:
            raise errors.refused(value, f'a whole number, at most {maximum}')
        return found

    metadata = {TAKES: convert, WHOLE: Range('', None, minimum, maximum)}
    return dataclasses.field(default=default, metadata=metadata)


def choice(*options: str, default: str | None = None) -> Any:
    """Field for one of several words. true and false, as YAML reads on and off, are accepted."""

    def convert(value: object) -> str:
        if isinstance(value, bool):
            value = 'on' if value else 'off'
        if value not in options:
            raise errors.InputError([errors.Mistake((), errors.must_be_one_of(options, value))])
        return str(value)

    return _field(convert, dataclasses.MISSING if default is None else default)


def boolean(*, default: bool) -> Any:
    """Field for true or false."""

    def convert(value: object) -> bool:
        if not isinstance(value, bool):
            raise errors.refused(value, 'true or false')
        return value

    return _field(convert, default)


def _is_name(value: object) -> bool:
    """Whether YAML may have read a value from a name; 8 is a name, too."""
    return isinstance(value, str | int) and not isinstance(value, bool) and fits_name(str(value))


def fits_name(text: str) -> bool:
    """Whether a text has the length of a name and characters that appear in logs and terminals."""
    return 0 < len(text) <= LONGEST_NAME and text.isprintable()


def places() -> Any:
    """Field for a mapping of names to points (x, y) on the table [m]."""
    coordinate = _number_within('m', None, None, None)

    def convert(value: object) -> dict[str, tuple[float, float]]:
        if not isinstance(value, Mapping):
            raise errors.refused(value, 'a mapping of names to [x, y]')
        found: ByName[tuple[float, float]] = ByName()
        mistakes: list[errors.Mistake] = []
        for key, point in value.items():
            name = str(key)
            if not _is_name(key):
                mistakes += errors.found_in(errors.refused(key, A_NAME), name)
                continue
            if name in found:
                mistakes.append(errors.Mistake((name,), errors.TWICE))
                continue
            try:
                x, y = point
                found[name] = coordinate(x), coordinate(y)
            except (TypeError, ValueError):
                mistakes += errors.found_in(
                    errors.refused(point, 'two finite numbers, [x, y]', unit='m'), name
                )
        if mistakes:
            raise errors.InputError(mistakes, valid_part=found)
        return found

    return dataclasses.field(default_factory=ByName, hash=False, metadata={TAKES: convert})


def name(*, nullable: bool = False) -> Any:
    """Field for the name of a ball; a `nullable` one is optional, and None by default."""

    def convert(value: object) -> str:
        if not _is_name(value):
            raise errors.refused(value, A_NAME)
        return str(value)

    return _required(convert, nullable)


def point(*, nullable: bool = False) -> Any:
    """Make a field for a point (x, y) on the table [m]; `nullable` as for `name`."""
    coordinate = _number_within('m', None, None, None)

    def convert(value: object) -> tuple[float, float]:
        try:
            x, y = (coordinate(each) for each in value)  # type: ignore[attr-defined]
            return x, y
        except (TypeError, ValueError):
            raise errors.refused(value, 'two finite numbers, (x, y)', unit='m') from None

    return _required(convert, nullable)


def section(
    kind: type,
    *,
    optional: bool = False,
    nullable: bool = False,
    named: Mapping[str, Any] = NO_NAMES,
) -> Any:
    """
    Field for a dataclass of such fields.

    An `optional` section is made of its defaults if it is missing; a `nullable` one is then None.
    A name among `named` stands for its value.
    """

    def convert(value: object) -> Any:
        if isinstance(value, str) and named:
            if value not in named:
                allowed = f'a mapping, or one of {", ".join(named)}'
                raise errors.refused(value, allowed, hint=errors.suggestion(named, value))
            return named[value]
        if not (nullable and value is None):
            check_type('', value, kind)
        return value

    metadata: dict[str, Any] = {TAKES: convert, SECTION_KEY: kind, NAMED: named}
    if nullable:
        return dataclasses.field(default=None, metadata=metadata)
    factory: Any = kind if optional else dataclasses.MISSING
    return dataclasses.field(default_factory=factory, metadata=metadata)


def _number_within(
    unit: str, above: float | None, minimum: float | None, maximum: float | None
) -> Callable[[object], float]:
    bounds = [
        f'{word} {bound:g}'
        for word, bound in (('above', above), ('at least', minimum), ('at most', maximum))
        if bound is not None
    ]
    allowed = ('a finite number ' + ' and '.join(bounds)).rstrip()

    def convert(value: object) -> float:
        found = as_float(value)
        if (
            not math.isfinite(found)
            or (above is not None and found <= above)
            or (minimum is not None and found < minimum)
            or (maximum is not None and found > maximum)
        ):
            hint = _in_thousandths(found, unit, maximum)
            raise errors.refused(value, allowed, unit=unit, hint=hint)
        return found

    return convert


def _required(convert: Convert, nullable: bool) -> Any:
    """Field without a default; if it is `nullable`, None is the default."""
    if nullable:
        return _field(_or_none(convert), None)
    return _field(convert, dataclasses.MISSING)


def _or_none(convert: Convert) -> Convert:
    return lambda value: None if value is None else convert(value)


def _in_thousandths(value: float, unit: str, maximum: float | None) -> str:
    """Say what a value that is too large is in grams, millimetres or milliseconds."""
    part = 1e-3 * value
    if unit not in THOUSANDTHS or maximum is None or not part <= maximum < value:
        return ''
    return f'; {value:g} {THOUSANDTHS[unit]} are {part:g} {unit}'


def _field(convert: Convert, default: Any) -> Any:
    return dataclasses.field(default=default, metadata={TAKES: convert})


S = TypeVar('S')


class _WrongFieldError(Exception):
    """A rule read a field whose value is invalid, or a method of a wrong section."""


class _Known:
    """The valid fields of an object, as attributes; a wrong section has no methods either."""

    def __init__(self, kind: type, values: dict[str, Any], is_wrong: bool = False) -> None:
        self._names = {field.name for field in _inputs(kind)} | set(dir(kind) if is_wrong else ())
        self._values = values

    def __getattr__(self, name: str) -> Any:
        if name in self._values:
            return self._values[name]
        raise _WrongFieldError(name) if name in self._names else AttributeError(name)


def check(instance: Any, **given: Any) -> None:
    """
    Convert and check every field of a frozen dataclass, and derive those that are not given.

    `given` are its init-only variables, which are checked like the fields.

    Raises
    ------
    InputError
        Naming each invalid field, its value and the allowed range.

    """
    kind = type(instance)
    fields = [field.name for field in dataclasses.fields(kind)]
    known, mistakes = _examine(kind, {name: getattr(instance, name) for name in fields} | given)
    if mistakes:
        raise errors.InputError(mistakes)
    for name in fields:
        object.__setattr__(instance, name, known[name])


class CheckedRecord:
    """A dataclass whose fields are checked when it is made; see `check`."""

    __slots__ = ()

    def __post_init__(self) -> None:
        check(self)


def read(kind: type[S], data: object) -> S:
    """
    Read a dataclass of such fields from a mapping.

    Raises
    ------
    InputError
        With all mistakes, including those of its sections.

    """
    found, mistakes = _read(kind, data)
    if mistakes:
        raise errors.InputError(mistakes)
    return found


def write(instance: Any, *, derived: bool = False) -> dict[str, Any]:
    """Plain dict from which `read` makes an equal object; with derived values if `derived`."""
    result = {}
    for field in dataclasses.fields(instance):
        value = getattr(instance, field.name)
        if value is None or (
            isinstance(value, DerivedNumber) and not (derived and value < math.inf)
        ):
            continue
        result[field.name] = _plain(value, derived)
    return result


class Description(NamedTuple):
    """What a docstring says about a field: its type, and in words, without the unit."""

    kind: str
    text: str


def descriptions(kind: type) -> dict[str, Description]:
    """Read the description of each field in the docstrings of a dataclass and its bases."""
    found = {}
    for each in reversed(kind.__mro__):
        words = cleandoc(each.__doc__ or '') + '\n'
        section = r'^(\w[\w, ]*) : (.*)\n((?:    .+\n)+)'
        for names, of_type, text in re.findall(section, words, re.MULTILINE):
            unit_left_out = re.sub(r' \[[^]]*\]\.$', '.', ' '.join(text.split()))
            found.update(dict.fromkeys(names.split(', '), Description(of_type, unit_left_out)))
    return found


def fill_in(instance: S, **values: float) -> S:
    """Copy of an object with values that are derived from data outside of it."""
    filled = copy.copy(instance)
    for name, value in values.items():
        object.__setattr__(filled, name, DerivedNumber(value))
    return filled


def _inputs(kind: Any) -> list[dataclasses.Field[Any]]:
    """Fields and init-only variables of a dataclass."""
    pseudo = (
        field
        for field in kind.__dataclass_fields__.values()
        if isinstance(field.type, dataclasses.InitVar)
    )
    return [*dataclasses.fields(kind), *pseudo]


def _no_mapping(value: object) -> errors.InputError:
    hint = '; it is empty' if value is None else ''
    return errors.refused(value, 'a mapping', hint=hint)


def _plain(value: Any, derived: bool) -> Any:
    if dataclasses.is_dataclass(value):
        return write(value, derived=derived)
    if isinstance(value, Mapping):
        return {key: _plain(each, derived) for key, each in value.items()}
    if isinstance(value, tuple):
        return [_plain(each, derived) for each in value]
    return float(value) if isinstance(value, DerivedNumber) else value


def _read(kind: type, data: object) -> tuple[Any, list[errors.Mistake]]:
    """Return the object and no mistakes, or its valid fields and its mistakes."""
    if not isinstance(data, Mapping):
        return _Known(kind, {}, is_wrong=True), list(errors.found_in(_no_mapping(data)))
    names = [field.name for field in _inputs(kind)]
    given = {}
    mistakes = []
    for key, value in data.items():
        if key in names:
            given[key] = value
        else:
            mistakes.append(errors.Mistake((str(key),), errors.unknown(str(key), names)))
    known, wrong = _examine(kind, given, reading=True)
    mistakes += wrong
    if mistakes:
        return _Known(kind, known, is_wrong=True), mistakes
    return kind(**{name: known[name] for name in given}), []


def _examine(
    kind: type, given: Mapping[str, Any], reading: bool = False
) -> tuple[dict[str, Any], list[errors.Mistake]]:
    """Return the valid values of a dataclass, and the mistakes of its fields and rules."""
    known: dict[str, Any] = {}
    mistakes: list[errors.Mistake] = []
    derived = []
    for field in _inputs(kind):
        name, metadata = field.name, field.metadata
        value = given[name] if name in given else _default(field)
        if value is dataclasses.MISSING:
            mistakes.append(errors.Mistake((name,), 'is missing'))
        elif DERIVED in metadata and (value is None or isinstance(value, DerivedNumber)):
            derived.append(field)
        elif reading and SECTION_KEY in metadata and isinstance(value, Mapping):
            known[name], wrong = _read(metadata[SECTION_KEY], value)
            mistakes += (mistake.below(name) for mistake in wrong)
        else:
            try:
                known[name] = metadata[TAKES](value)
            except ValueError as error:
                mapping = reading and SECTION_KEY in metadata and not metadata[NAMED]
                mistakes += errors.found_in(_no_mapping(value) if mapping else error, name)
                if isinstance(error, errors.InputError) and error.valid_part is not None:
                    known[name] = error.valid_part
    so_far = _Known(kind, known)
    for field in derived:
        try:
            known[field.name] = DerivedNumber(field.metadata[DERIVED](so_far))
        except _WrongFieldError:
            continue
    mistakes += _conflicts(kind, so_far)
    return known, mistakes


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def _conflicts(kind: Any, known: _Known) -> Iterator[errors.Mistake]:
    for rule in getattr(kind, 'RULES', ()):
        try:
            yield from rule(known)
        except _WrongFieldError:
            continue
