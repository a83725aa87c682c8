"""The description of a library: how its entries are called, and its header for C and C++."""

from collections.abc import Iterator
from importlib import import_module
from inspect import cleandoc
from itertools import count
import re
from typing import Any, get_args, get_type_hints

import numpy as np

from billiard_shot import machine_code
from billiard_shot.compiled import Entry
from billiard_shot.planning.pockets import BallKind
from billiard_shot.records import record_layout, ROWS, storage_kind
from billiard_shot.status import Status
from billiard_shot.table.model.motion import Cause, Motion

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
        'of': storage_kind(value.dtype),
    }
    for _ in range(value.ndim):
        next(slots)
    if value.dtype.names:
        (kind,) = get_args(hint)
        assert kind.dtype == value.dtype, f'{name} is annotated with another record'
        argument['of'] = of = f'{kind.__module__}:{kind.__qualname__}'
        records[of] = record_layout(kind)
    return argument


# A number in a table of arguments takes a word.
_C_NUMBERS = {'f8': 'double', 'i8': 'int64_t', 'b1': 'int64_t'}
_C_FIELDS = _C_NUMBERS | {'b1': 'bool'}
_BEGIN = """\
/*
 * The compiled core of billiard_shot, for C and C++; made with the library that it describes.
 *
 * An entry takes a struct of its arguments, named like the entry. Of an array the struct has the
 * address and, as `NAME_shape`, its dimensions; arrays are in C order. Truths are 0 or 1.
 * `billiard-shot export SCENE -o scene.h` writes such structs for a scene.
 */
#ifndef BILLIARD_SHOT_H
#define BILLIARD_SHOT_H

#include <assert.h>
#include <stdbool.h>
#include <stdint.h>

#define BILLIARD_SHOT_SOURCES 0x{sources}

#ifdef __cplusplus
extern "C" {{
#endif
"""
_END = """
#ifdef __cplusplus
}
#endif
#endif
"""


def header_of(description: dict[str, Any], entries: list[Entry]) -> str:
    """Write the header of a library that has entries."""
    parts = [_BEGIN.format(sources=description['sources'])]
    for name, members in description['constants'].items():
        prefix = re.sub('(?<=.)(?=[A-Z])', '_', name).upper()
        values = [f'{prefix}_{each} = {value},' for each, value in members.items()]
        parts.append(f'enum {_block(values)};\n')
    for name, layout in description['records'].items():
        module, kind = name.split(':')
        fields = [
            f'{_C_FIELDS[field["kind"]]} {field["name"]}{_shape(field["shape"])};'
            for field in layout['fields']
        ]
        about = getattr(import_module(module), kind).__doc__
        path = f'{module.replace(".", "/")}.py'
        parts.append(
            f'{_comment(f"{cleandoc(about)} See {path}.")}'
            f'typedef struct {_block(fields)} {kind};\n'
            f'static_assert(sizeof({kind}) == {layout["size"]}, "layout of {kind}");\n'
        )
    for entry in entries:
        name = entry.function.__name__
        described = description['entries'][name]
        parts.append(
            f'struct {name} {_block(_members(described["arguments"]))};\n'
            f'static_assert(sizeof(struct {name}) == {8 * described["words"]}, "64 bits");\n\n'
            f'{_comment(cleandoc(entry.__doc__ or ""))}'
            f'int64_t {name}(struct {name} *arguments);\n'
        )
    return '\n'.join(parts) + _END


def type_of(kind: str) -> str:
    """Return the type of the elements of an array, from its description."""
    return kind.split(':')[1] if ':' in kind else _C_FIELDS[kind]


def _members(arguments: list[dict[str, Any]]) -> list[str]:
    """Declare arguments as members of a struct."""
    members = []
    for argument in arguments:
        name = argument['name']
        if argument['kind'] == 'tuple':
            members.append(f'struct {_block(_members(argument["fields"]))} {name};')
        elif argument['kind'] == 'array':
            dimensions = argument['dimensions']
            members.append(f'{type_of(argument["of"])} *{name};')
            members.append(f'int64_t {name}_shape[{dimensions}];')
        else:
            members.append(f'{_C_NUMBERS[argument["kind"]]} {name};')
    return members


def _shape(shape: list[int]) -> str:
    return ''.join(f'[{each}]' for each in shape)


def _block(lines: list[str]) -> str:
    indented = [f'  {line}' for each in lines for line in each.split('\n')]
    return '\n'.join(['{', *indented, '}'])


def _comment(text: str) -> str:
    lines = [f' * {line}'.rstrip() for line in text.strip().split('\n')]
    return '\n'.join(['/*', *lines, ' */', ''])
