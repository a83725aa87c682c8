"""
The description of a library: how its entries are called, and where the fields of records lie.

The description is a file of JSON beside the library. Programs that call entries read it. An entry
takes the address of a table of 64-bit words, and returns one word:

    sources   digest of the sources of the library
    files     the SHA-256 of each file that was built from them
    entries   by name: `arguments`, and the number of `words` of their table
    records   by name (module:class): its `size`; name, offset, kind and shape of its `fields`
    constants what whole numbers in records and arguments mean, by the name of their enumeration

An argument has a `name` and a `kind`. Numbers are f8 (a double), i8 or b1. Their `slot` is their
word in the table. An `array` is in C order. Its slot has its address, and the next slots have its
lengths along its `dimensions`; `of` is the kind of its elements, or their record. A `tuple` has
`fields`, which are arguments, and no word of its own.
"""

from collections.abc import Iterator
from itertools import count
from typing import Any, get_args, get_type_hints

import numpy as np

from billiard_shot import machine_code
from billiard_shot.compiled import Entry
from billiard_shot.planning.pot_directions import BallKind
from billiard_shot.records import kind_of, layout_of, ROWS
from billiard_shot.status import Status
from billiard_shot.table.motion import Cause, Motion

_NUMBERS = {float: 'f8', int: 'i8', bool: 'b1'}


def describe(entries: list[Entry]) -> dict[str, Any]:
    """Describe a library of entries; `files` are not known yet."""
    records: dict[str, Any] = {}
    return {
        'sources': machine_code.sources(),
        'files': {},
        'entries': {entry.function.__name__: _entry(entry, records) for entry in entries},
        'records': records,
        'constants': {
            kind.__name__: {each.name: int(each) for each in kind}
            for kind in (Status, Motion, Cause, BallKind)
        },
    }


def _entry(entry: Entry, records: dict[str, Any]) -> dict[str, Any]:
    """Describe an entry; add the records that it uses."""
    slots, hints = count(), get_type_hints(entry.function)
    arguments = [
        _argument(name, value, hint, slots, records)
        for (name, hint), value in zip(hints.items(), entry.example(ROWS), strict=False)
    ]
    return {'arguments': arguments, 'words': next(slots)}


def _argument(
    name: str, value: Any, hint: Any, slots: Iterator[int], records: dict[str, Any]
) -> dict[str, Any]:
    """Describe an argument by its example and its annotation, which names the class of records."""
    if isinstance(value, tuple):
        names = getattr(value, '_fields', None) or map(str, range(len(value)))
        hints = get_type_hints(type(value)).values() or get_args(hint)
        fields = [
            _argument(*each, slots, records) for each in zip(names, value, hints, strict=True)
        ]
        return {'name': name, 'kind': 'tuple', 'fields': fields}
    if not isinstance(value, np.ndarray):
        return {'name': name, 'kind': _NUMBERS[type(value)], 'slot': next(slots)}
    argument: dict[str, Any] = {
        'name': name,
        'kind': 'array',
        'slot': next(slots),
        'dimensions': value.ndim,
        'of': kind_of(value.dtype),
    }
    for _ in range(value.ndim):
        next(slots)
    if value.dtype.names:
        (kind,) = get_args(hint)
        assert kind.dtype == value.dtype, f'{name} is annotated with another record'
        argument['of'] = of = f'{kind.__module__}:{kind.__qualname__}'
        records[of] = layout_of(kind)
    return argument
