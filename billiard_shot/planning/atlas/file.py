"""
Atlases as files: JSON lines, first the request, then one line for each finished layout.

Lines are only appended, so that no result is lost however a run ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
import json
from pathlib import Path
from typing import Any

from billiard_shot.planning.atlas.build import LayoutResult
from billiard_shot.planning.atlas.layouts import Layout
from billiard_shot.planning.atlas.maps import Atlas
from billiard_shot.planning.atlas.request import AtlasRequest, with_defaults
from billiard_shot.scene import Scene
from billiard_shot.scene.checks import read, write
from billiard_shot.scene.errors import InputError, reason
from billiard_shot.scene.player import OFFSETS
from billiard_shot.status import Status

ATLAS_FORMAT = 1


def start_file(path: Path, scene: Scene, request: AtlasRequest) -> list[LayoutResult]:
    """
    Start the file of an atlas, or continue it and return the results that it holds.

    An incomplete last line is removed.

    Raises
    ------
    ValueError
        If the file is not an atlas file; if it holds another atlas, naming every field that
        differs; or if it cannot be read or written.

    """
    head = _head(scene, with_defaults(scene, request))
    try:
        if not path.exists() or not path.stat().st_size:
            path.write_text(_line(head), encoding='utf-8')
            return []
        lines, whole = _lines(path)
        there = _head_of(path, lines)
        if differences := list(_differences(there, head)):
            raise ValueError('\n  '.join([f'{path} holds another atlas', *differences]))
        with path.open('r+b') as file:
            file.truncate(whole)
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from error
    return _results(path, lines)


def append(path: Path, result: LayoutResult) -> None:
    """Append a result to a file; ValueError if it cannot be written."""
    try:
        with path.open('a', encoding='utf-8') as file:
            file.write(_line(_as_json(result)))
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from error


def load_atlas(path: str | Path) -> Atlas:
    """
    Read a finished or unfinished atlas from its file.

    Raises
    ------
    ValueError
        If the file is not an atlas file, or cannot be read.

    """
    path = Path(path)
    try:
        lines, _ = _lines(path)
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from error
    head = _head_of(path, lines)
    asked = {key: value for key, value in head.items() if key not in ('atlas', 'scene')}
    try:
        scene, request = Scene.from_dict(head['scene']), read(AtlasRequest, asked)
    except InputError as error:
        raise InputError(error.mistakes, str(path)) from error
    return Atlas(scene, request, _results(path, lines))


def _head(scene: Scene, request: AtlasRequest) -> dict[str, Any]:
    head = {'atlas': ATLAS_FORMAT, **write(request), 'scene': scene.to_dict()}
    return dict(json.loads(_line(head)))  # as it is read back: lists for tuples


def _lines(path: Path) -> tuple[list[bytes], int]:
    """Return the complete lines, and their size in bytes."""
    data = path.read_bytes()
    whole = data.rfind(b'\n') + 1
    return data[:whole].splitlines(), whole


def _head_of(path: Path, lines: list[bytes]) -> dict[str, Any]:
    try:
        head = json.loads(lines[0])
        known = head['atlas'], head['scene']
    except (IndexError, KeyError, TypeError, ValueError):
        raise ValueError(f'{path} exists but is not an atlas file') from None
    if known[0] != ATLAS_FORMAT:
        raise ValueError(f'{path}: atlas must be {ATLAS_FORMAT}, got {known[0]!r}')
    return dict(head)


def _differences(there: Any, wanted: Any, *keys: str) -> Iterator[str]:
    if isinstance(there, Mapping) and isinstance(wanted, Mapping):
        for key in sorted({*there, *wanted}):
            yield from _differences(there.get(key), wanted.get(key), *keys, key)
    elif there != wanted:
        yield f'{".".join(keys)}: {_said(there)} in the file, {_said(wanted)} in the request'


def _said(value: object) -> str:
    return 'not given' if value is None else json.dumps(value, ensure_ascii=False)


def _results(path: Path, lines: list[bytes]) -> list[LayoutResult]:
    """Read all results; two runs may have planned the same layout, with the same result."""
    found = {}
    for number, line in enumerate(lines[1:], 2):
        try:
            result = _from_json(json.loads(line))
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(
                f'{path}: line {number} is not a result of an atlas ({error!r}); the file can '
                'be used without this line'
            ) from None
        found[result.layout] = result
    return list(found.values())


def _line(data: object) -> str:
    return json.dumps(data, ensure_ascii=False, allow_nan=False) + '\n'


def _as_json(result: LayoutResult) -> dict[str, Any]:
    return {
        'ball': result.layout.ball,
        'ball_place': result.layout.ball_place,
        'cue_place': result.layout.cue_place,
        'status': result.status.name,
        'message': result.message,
        'success': result.success,
        'interval': result.interval,
        'successes': result.successes,
        'trials': result.trials,
        'simulations': result.simulations,
        'kind': result.kind,
        'stroke': result.stroke and dict(zip(OFFSETS, result.stroke, strict=True)),
    }


def _from_json(data: Mapping[str, Any]) -> LayoutResult:
    (ball_x, ball_y), (cue_x, cue_y) = data['ball_place'], data['cue_place']
    stroke = data['stroke']
    return LayoutResult(
        Layout(data['ball'], (ball_x, ball_y), (cue_x, cue_y)),
        Status[data['status']],
        data['message'],
        data['simulations'],
        data['successes'],
        data['trials'],
        kind=data['kind'],
        stroke=stroke and tuple(stroke[name] for name in OFFSETS),
    )
