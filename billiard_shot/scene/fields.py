"""
Fields with the values that they allow, for dataclasses that check themselves (see checks.py).

A field is declared by its type: `number`, `choice`, `boolean`, `places`, `section` ... A field
with a `derived` value computes it from the other fields if none is given, and again whenever
`dataclasses.replace` makes a new object: such a value is marked as `Derived`.
"""

from collections.abc import Callable, Mapping
import dataclasses
import math
from typing import Any, NamedTuple

from billiard_shot.scene.by_name import ByName
from billiard_shot.scene.errors import (
    found_in,
    InputError,
    Mistake,
    must_be_one_of,
    refused,
    TWICE,
)
from billiard_shot.scene.values import as_float, check_type, whole

Convert = Callable[[object], Any]
TAKES, DERIVED, SECTION_KEY = 'takes', 'derived', 'section'
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


class Derived(float):
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


def whole_number(*, minimum: int, default: int, maximum: int | None = None) -> Any:
    """Field for an integer, at least `minimum` and at most `maximum`."""

    def convert(value: object) -> int:
        found = whole('', value, minimum)
        if maximum is not None and found > maximum:
            raise refused(value, f'a whole number, at most {maximum}')
        return found

    metadata = {TAKES: convert, WHOLE: Range('', None, minimum, maximum)}
    return dataclasses.field(default=default, metadata=metadata)


def choice(*options: str, default: str | None = None) -> Any:
    """Field for one of several words. true and false, as YAML reads on and off, are accepted."""

    def convert(value: object) -> str:
        if isinstance(value, bool):
            value = 'on' if value else 'off'
        if value not in options:
            raise InputError([Mistake((), must_be_one_of(options, value))])
        return str(value)

    return _field(convert, dataclasses.MISSING if default is None else default)


def boolean(*, default: bool) -> Any:
    """Field for true or false."""

    def convert(value: object) -> bool:
        if not isinstance(value, bool):
            raise refused(value, 'true or false')
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
            raise refused(value, 'a mapping of names to [x, y]')
        found: ByName[tuple[float, float]] = ByName()
        mistakes: list[Mistake] = []
        for key, point in value.items():
            name = str(key)
            if not _is_name(key):
                mistakes += found_in(refused(key, A_NAME), name)
                continue
            if name in found:
                mistakes.append(Mistake((name,), TWICE))
                continue
            try:
                x, y = point
                found[name] = coordinate(x), coordinate(y)
            except (TypeError, ValueError):
                mistakes += found_in(refused(point, 'two finite numbers, [x, y]', unit='m'), name)
        if mistakes:
            raise InputError(mistakes, valid_part=found)
        return found

    return dataclasses.field(default_factory=ByName, hash=False, metadata={TAKES: convert})


def name(*, nullable: bool = False) -> Any:
    """Field for the name of a ball; a `nullable` one is optional, and None by default."""

    def convert(value: object) -> str:
        if not _is_name(value):
            raise refused(value, A_NAME)
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
            raise refused(value, 'two finite numbers, (x, y)', unit='m') from None

    return _required(convert, nullable)


def section(kind: type, *, optional: bool = False, nullable: bool = False) -> Any:
    """
    Field for a dataclass of such fields.

    An `optional` section is made of its defaults if it is missing; a `nullable` one is then None.
    """

    def convert(value: object) -> Any:
        if not (nullable and value is None):
            check_type('', value, kind)
        return value

    metadata: dict[str, Any] = {TAKES: convert, SECTION_KEY: kind}
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
            raise refused(value, allowed, unit=unit, hint=hint)
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
