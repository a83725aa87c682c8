"""A scene for C and C++: the arguments of the entries, as static data of a header."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot import machine_code
from billiard_shot.compiler.build import HEADER
from billiard_shot.compiler.description import describe
from billiard_shot.compiler.header import type_of
from billiard_shot.embed.packed import packed_scene
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.shot.setting import setting_of

_BEGIN = """\
/* Arguments of the entries of billiard_shot, for a scene. Its balls: {names}. */
#include <math.h>
#include "{file}"

#if BILLIARD_SHOT_SOURCES != 0x{sources}
#error "{file} belongs to another version: export the scene with that version"
#endif
"""


def c_scene(scene: SceneLike) -> str:
    """
    Write a scene as a header for C: for each entry its arguments, `ENTRY_arguments`.

    There is room for one table of the balls of the scene and one stroke. Who calls the entries
    writes where balls lie, and the stroke.
    """
    scene = Scene.load(scene)
    names = ', '.join(f'{i} {name}' for i, name in enumerate(setting_of(scene).names))
    balls = names.replace('*/', '* /')  # which would end the comment
    parts = [_BEGIN.format(names=balls, file=HEADER, sources=machine_code.sources())]
    made = packed_scene(scene)
    described = describe(list(made))['entries']
    for entry, arguments in made.items():
        name = entry.function.__name__
        values = _struct(described[name]['arguments'], arguments, name, parts)
        parts.append(f'static struct {name} {name}_arguments = {values};\n')
    return '\n'.join(parts)


def _struct(
    described: list[dict[str, Any]], values: dict[str, Any], path: str, parts: list[str]
) -> str:
    """Write arguments as an initializer, after the arrays in them, which go to `parts`."""
    members = []
    for argument in described:
        name, kind = argument['name'], argument['kind']
        value, symbol = values[name], f'{path}_{name}'
        if kind == 'tuple':
            written = _struct(argument['fields'], value._asdict(), symbol, parts)
            members.append(f'.{name} = {written}')
        elif kind == 'array':
            if value.size:
                content = _array(value)
                parts.append(f'static {type_of(argument["of"])} {symbol}[{value.size}]{content};')
            members.append(f'.{name} = {symbol if value.size else 0}')
            members.append(f'.{name}_shape = {{{", ".join(map(str, value.shape))}}}')
        else:
            members.append(f'.{name} = {_number(value)}')
    return f'{{{", ".join(members)}}}'


def _array(values: NDArray[Any]) -> str:
    """Write the initializer of an array; none if all is zero."""
    if not any(values.tobytes()):
        return ''
    return f' = {_number(tuple(values.ravel().tolist()))}'


def _number(value: Any) -> str:
    """Write a number, or those of a record."""
    if isinstance(value, np.ndarray):
        return _number(tuple(value.tolist()))
    if isinstance(value, tuple):
        return f'{{{", ".join(map(_number, value))}}}'
    if not isinstance(value, float):
        return str(int(value))
    if math.isfinite(value):
        return repr(float(value))
    return 'NAN' if math.isnan(value) else f'{"-" * (value < 0)}INFINITY'
