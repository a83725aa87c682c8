"""Scenes for programs without Python, as JSON for JavaScript, as a header for C; and the core."""

from base64 import b64encode
from inspect import signature
import json
import math
from pathlib import Path
import shutil
from typing import Any
import zlib

import numpy as np
from numpy.typing import NDArray

from billiard_shot import machine_code
from billiard_shot.compiled import Entry
from billiard_shot.compiler.build import HEADER, NOTICE, PAGES, provide
from billiard_shot.compiler.description import describe, type_of
from billiard_shot.impact.kernel import new_scratch
from billiard_shot.numerics import rounding
from billiard_shot.planning.direct_shots import find_direct_shots
from billiard_shot.planning.pockets import LEGAL, PRESENT
from billiard_shot.planning.shots import arguments_of
from billiard_shot.records import ROWS
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.fields import LARGEST
from billiard_shot.scene.player import MIN_NOISY_SPEED, OFFSETS
from billiard_shot.shot.play import Accuracy, DEFAULT_SHOT_TOLERANCE, prepared_scene, task_of
from billiard_shot.shot.stroke import SPEED_RANGE, write_strokes
from billiard_shot.table.contacts.cluster import room_for
from billiard_shot.table.model.motion import room_for_simulation
from billiard_shot.table.motion.boundaries import HOLES
from billiard_shot.table.run.layout import layout_of
from billiard_shot.table.run.results import cushion_name, POCKET_NAMES
from billiard_shot.table.run.task import CAPACITY, packed, play_tables


def plain(value: Any) -> Any:
    """Return arguments as JSON has them; arrays of zeros as their shapes."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value).replace('inf', 'Infinity')  # JSON has none; this is one in JavaScript
    if isinstance(value, dict):
        return {name: plain(each) for name, each in value.items()}
    if hasattr(value, '_asdict'):
        return plain(value._asdict())
    if not isinstance(value, np.ndarray):
        return value
    if not any(value.tobytes()):
        return {'shape': value.shape}
    rows, names = value.ravel().tolist(), value.dtype.names
    if names:
        rows = [dict(zip(names, map(_field, row), strict=True)) for row in rows]
    return {'shape': value.shape, 'values': [plain(row) for row in rows]}


def _field(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value


def packed_scene(
    scene: Scene, tolerance: float = DEFAULT_SHOT_TOLERANCE
) -> dict[Entry, dict[str, Any]]:
    """
    Pack a scene as arguments of each entry, with room for one table of its balls and a stroke.

    Who calls the entries writes where balls lie, and the stroke; all else is there. Arrays of the
    entries are apart: the vectors that `write_strokes` writes are to be given to `play_tables`.
    Without pockets there is no `find_direct_shots`.
    """
    count = len(prepared_scene(scene).names)
    played = packed_play(scene, tolerance)
    made = {
        write_strokes: _named(
            write_strokes, (np.zeros((1, 5)), np.zeros((1, 3)), np.zeros((1, 3)))
        ),
        play_tables: played,
    }
    if len(played['layout'].pockets):
        places, kinds = np.zeros((1, count, 2)), np.array([[PRESENT] + [LEGAL] * (count - 1)])
        made[find_direct_shots] = _named(
            find_direct_shots, arguments_of(ROWS, scene, scene.planned_noise, places, kinds, 0)
        )
    return made


def packed_play(scene: Scene, tolerance: float = DEFAULT_SHOT_TOLERANCE) -> dict[str, Any]:
    """Pack a scene as arguments of `play_tables` alone; see `packed_scene`."""
    prepared = prepared_scene(scene)
    count = len(prepared.names)
    task = task_of(prepared, np.zeros((1, 3)), np.zeros((1, 3)), None, Accuracy(tolerance))
    room = room_for(ROWS, count, True)  # with scratch that this thread has used
    capacity = CAPACITY * (2 + count)
    room = room._replace(
        scratch=new_scratch(ROWS, len(room.properties)),
        participants=np.zeros((capacity, 2), np.int64),
    )
    rooms = room_for_simulation(ROWS, count), room
    named = _named(play_tables, packed(task, ROWS, rooms, capacity, capacity))
    for record in (named['tables'].segments, named['tables'].events):
        record.view(np.uint8).fill(0)  # it was not set
    return named


def _named(entry: Entry, arguments: tuple[Any, ...]) -> dict[str, Any]:
    return dict(zip(signature(entry.function).parameters, arguments, strict=True))


def export_scene(scene: SceneLike, tolerance: float = DEFAULT_SHOT_TOLERANCE) -> dict[str, Any]:
    """
    Export a scene for pages that play strokes in it.

    Parameters
    ----------
    scene : Scene, str or Path
    tolerance : float
        Largest error of the trajectories [m].

    Returns
    -------
    dict
        For `json.dumps`. It belongs to the version of the compiled core that this package has.

    """
    scene = Scene.load(scene)
    prepared, radius = prepared_scene(scene), float(scene.ball.radius)
    layout = layout_of(prepared.model.surface, prepared.table)
    numbers = layout.numbers
    beyond = numbers.cushion_depth
    return {
        'sources': machine_code.sources(),
        'names': prepared.names,
        'places': {
            name: place[:2]
            for name, place in zip(
                prepared.names, prepared.starts['position'][0].tolist(), strict=True
            )
        },
        'pockets': POCKET_NAMES if layout.pockets else (),
        'cushions': [cushion_name(feature) for feature in range(HOLES)],
        'radius': radius,
        'apart': (2.0 * radius - rounding.PLACE, 2.0 * LARGEST, 'm'),
        'ranges': {
            'a': (-LARGEST, LARGEST, 'ball radii'),
            'b': (-LARGEST, LARGEST, 'ball radii'),
            'elevation': (-0.5 * math.pi, 0.5 * math.pi, 'rad'),
            'azimuth': (-2.0 * math.pi, 2.0 * math.pi, 'rad'),
            'speed': (*SPEED_RANGE, 'm/s'),
            'x': _range(numbers.nose_half_length + beyond),
            'y': _range(numbers.nose_half_width + beyond),
        },
        'noise': dict(zip(OFFSETS, scene.planned_noise.sigmas(radius).tolist(), strict=True)),
        'slowest': MIN_NOISY_SPEED,
        'entries': {
            entry.function.__name__: plain(arguments)
            for entry, arguments in packed_scene(scene, tolerance).items()
        },
    }


def _range(half: float) -> tuple[float, float, str]:
    half = min(half, LARGEST)
    return -half, half, 'm'


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
    names = ', '.join(f'{i} {name}' for i, name in enumerate(prepared_scene(scene).names))
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


MODULE = Path(__file__).with_name('web')


def core_folder(target: str) -> Path:
    """
    Find the folder with the core for a target; build the core if there is none.

    Raises
    ------
    ValueError
        If it cannot be built.

    """
    if any(machine_code.PACKAGED.glob(f'{target}.*')):
        return machine_code.PACKAGED
    try:
        return provide(target)
    except (ModuleNotFoundError, RuntimeError) as error:
        raise ValueError(f'the core for {target} cannot be built: {error}') from None


def copy_module(folder: Path) -> None:
    """Copy the JavaScript module and the core into a folder, which then is a package for npm."""
    core = core_folder(PAGES)
    shutil.copy(core / f'{PAGES}.wasm', folder / 'core.wasm')
    for file in (core / machine_code.DESCRIPTION, core / NOTICE, *MODULE.iterdir()):
        shutil.copy(file, folder)


def copy_library(folder: Path) -> None:
    """Copy the header and the library for this machine into a folder."""
    core = core_folder(machine_code.LIBRARY)
    for file in (core / HEADER, core / NOTICE, *core.glob(f'{machine_code.LIBRARY}.*')):
        shutil.copy(file, folder)


def core_script() -> str:
    """
    Write the core as a script that pages on any host, or without one, can include.

    It defines `billiardShotCore`: the text of the `module`, and `wasm` and `description`,
    compressed, in base64.
    """
    core = core_folder(PAGES)
    parts = {
        'module': (MODULE / 'core.mjs').read_text(encoding='utf-8'),
        'wasm': _compressed(core / f'{PAGES}.wasm'),
        'description': _compressed(core / machine_code.DESCRIPTION),
    }
    return f'const billiardShotCore = {json.dumps(parts)};'.replace('<', '\\u003c')


def _compressed(file: Path) -> str:
    return b64encode(zlib.compress(file.read_bytes(), 9)).decode()
