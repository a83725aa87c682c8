"""
Dataclasses that check themselves, and are read from mappings with all mistakes found at once.

A dataclass made of fields from fields.py calls `check` in its `__post_init__`. A condition on
several fields is a rule: a generator of mistakes, called with the object, which the class lists in
`RULES`. A rule is skipped if one of the fields that it reads is invalid.
"""

from collections.abc import Iterator, Mapping
import copy
import dataclasses
import math
from typing import Any, TypeVar

from billiard_shot.scene.errors import found_in, InputError, Mistake, refused, unknown
from billiard_shot.scene.fields import DERIVED, Derived, SECTION_KEY, TAKES

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
        raise InputError(mistakes)
    for name in fields:
        object.__setattr__(instance, name, known[name])


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
        raise InputError(mistakes)
    return found


def write(instance: Any, *, derived: bool = False) -> dict[str, Any]:
    """Plain dict from which `read` makes an equal object; with derived values if `derived`."""
    result = {}
    for field in dataclasses.fields(instance):
        value = getattr(instance, field.name)
        if value is None or (isinstance(value, Derived) and not (derived and value < math.inf)):
            continue
        result[field.name] = _plain(value, derived)
    return result


def fill_in(instance: S, **values: float) -> S:
    """Copy of an object with values that are derived from data outside of it."""
    filled = copy.copy(instance)
    for name, value in values.items():
        object.__setattr__(filled, name, Derived(value))
    return filled


def _inputs(kind: Any) -> list[dataclasses.Field[Any]]:
    """Fields and init-only variables of a dataclass."""
    pseudo = (
        field
        for field in kind.__dataclass_fields__.values()
        if isinstance(field.type, dataclasses.InitVar)
    )
    return [*dataclasses.fields(kind), *pseudo]


def _no_mapping(value: object) -> InputError:
    hint = '; it is empty' if value is None else ''
    return refused(value, 'a mapping', hint=hint)


def _plain(value: Any, derived: bool) -> Any:
    if dataclasses.is_dataclass(value):
        return write(value, derived=derived)
    if isinstance(value, Mapping):
        return {key: _plain(each, derived) for key, each in value.items()}
    if isinstance(value, tuple):
        return [_plain(each, derived) for each in value]
    return float(value) if isinstance(value, Derived) else value


def _read(kind: type, data: object) -> tuple[Any, list[Mistake]]:
    """Return the object and no mistakes, or its valid fields and its mistakes."""
    if not isinstance(data, Mapping):
        return _Known(kind, {}, is_wrong=True), list(found_in(_no_mapping(data)))
    names = [field.name for field in _inputs(kind)]
    given = {}
    mistakes = []
    for key, value in data.items():
        if key in names:
            given[key] = value
        else:
            mistakes.append(Mistake((str(key),), unknown(str(key), names)))
    known, wrong = _examine(kind, given, reading=True)
    mistakes += wrong
    if mistakes:
        return _Known(kind, known, is_wrong=True), mistakes
    return kind(**{name: known[name] for name in given}), []


def _examine(
    kind: type, given: Mapping[str, Any], reading: bool = False
) -> tuple[dict[str, Any], list[Mistake]]:
    """Return the valid values of a dataclass, and the mistakes of its fields and rules."""
    known: dict[str, Any] = {}
    mistakes: list[Mistake] = []
    derived = []
    for field in _inputs(kind):
        name, metadata = field.name, field.metadata
        value = given[name] if name in given else _default(field)
        if value is dataclasses.MISSING:
            mistakes.append(Mistake((name,), 'is missing'))
        elif DERIVED in metadata and (value is None or isinstance(value, Derived)):
            derived.append(field)
        elif reading and SECTION_KEY in metadata and isinstance(value, Mapping):
            known[name], wrong = _read(metadata[SECTION_KEY], value)
            mistakes += (mistake.below(name) for mistake in wrong)
        else:
            try:
                known[name] = metadata[TAKES](value)
            except ValueError as error:
                mapping = reading and SECTION_KEY in metadata
                mistakes += found_in(_no_mapping(value) if mapping else error, name)
                if isinstance(error, InputError) and error.valid_part is not None:
                    known[name] = error.valid_part
    so_far = _Known(kind, known)
    for field in derived:
        try:
            known[field.name] = Derived(field.metadata[DERIVED](so_far))
        except _WrongFieldError:
            continue
    mistakes += _conflicts(kind, so_far)
    return known, mistakes


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default_factory is not dataclasses.MISSING:
        return field.default_factory()
    return field.default


def _conflicts(kind: Any, known: _Known) -> Iterator[Mistake]:
    for rule in getattr(kind, 'RULES', ()):
        try:
            yield from rule(known)
        except _WrongFieldError:
            continue
