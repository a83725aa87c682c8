"""
Atlases as files: JSON lines, the request first, then a line for each place as it is done.

Lines are only ever added, so that what was done is not lost, however a run ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
import json
from pathlib import Path
from typing import Any

from billiard_shot.planning.atlas.maps import Atlas
from billiard_shot.planning.atlas.places import Place
from billiard_shot.planning.atlas.request import AtlasRequest, settled
from billiard_shot.planning.atlas.survey import PlaceChance
from billiard_shot.scene import Scene
from billiard_shot.scene.checks import read, write
from billiard_shot.scene.mistakes import InputError
from billiard_shot.status import Status

FORMAT = 1
OFFSETS = ('a', 'b', 'elevation', 'azimuth', 'speed')


def begin(path: Path, scene: Scene, request: AtlasRequest) -> list[PlaceChance]:
    """
    Begin a file for an atlas, or go on with one: then these places are done.

    A last line that was not written to its end is taken away.

    Raises
    ------
    ValueError
        If the file holds something else, or another atlas: then with every field that differs.
        Also if it cannot be read or written.

    """
    head = _head(scene, settled(scene, request))
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
        raise ValueError(f'{path}: {error}') from error
    return _chances(path, lines)


def append(path: Path, chance: PlaceChance) -> None:
    """Add a place that is done to a file; ValueError if it cannot be written."""
    try:
        with path.open('a', encoding='utf-8') as file:
            file.write(_line(_as_json(chance)))
    except OSError as error:
        raise ValueError(f'{path}: {error}') from error


def load_atlas(path: str | Path) -> Atlas:
    """
    Read an atlas from its file, finished or not.

    Raises
    ------
    ValueError
        If the file holds no atlas, or cannot be read.

    """
    path = Path(path)
    try:
        lines, _ = _lines(path)
    except OSError as error:
        raise ValueError(f'{path}: {error}') from error
    head = _head_of(path, lines)
    asked = {key: value for key, value in head.items() if key not in ('atlas', 'scene')}
    try:
        scene, request = Scene.from_dict(head['scene']), read(AtlasRequest, asked)
    except InputError as error:
        raise InputError(error.mistakes, str(path)) from error
    return Atlas(scene, request, _chances(path, lines))


def _head(scene: Scene, request: AtlasRequest) -> dict[str, Any]:
    head = {'atlas': FORMAT, **write(request), 'scene': scene.to_dict()}
    return dict(json.loads(_line(head)))  # as it comes back: lists for tuples


def _lines(path: Path) -> tuple[list[bytes], int]:
    """Lines that are there to their ends, and how many bytes they take."""
    data = path.read_bytes()
    whole = data.rfind(b'\n') + 1
    return data[:whole].splitlines(), whole


def _head_of(path: Path, lines: list[bytes]) -> dict[str, Any]:
    try:
        head = json.loads(lines[0])
        known = head['atlas'], head['scene']
    except (IndexError, KeyError, TypeError, ValueError):
        raise ValueError(f'{path} is not allowed; it is there, and is no atlas') from None
    if known[0] != FORMAT:
        raise ValueError(f'{path}: atlas: {known[0]!r} is not allowed; it must be {FORMAT}')
    return dict(head)


def _differences(there: Any, wanted: Any, *keys: str) -> Iterator[str]:
    if isinstance(there, Mapping) and isinstance(wanted, Mapping):
        for key in sorted({*there, *wanted}):
            yield from _differences(there.get(key), wanted.get(key), *keys, key)
    elif there != wanted:
        yield f'{".".join(keys)}: there it is {_said(there)}, asked for is {_said(wanted)}'


def _said(value: object) -> str:
    return 'not given' if value is None else json.dumps(value, ensure_ascii=False)


def _chances(path: Path, lines: list[bytes]) -> list[PlaceChance]:
    """Read all places; one that is there twice was planned by two runs, with the same result."""
    found = {}
    for number, line in enumerate(lines[1:], 2):
        try:
            chance = _from_json(json.loads(line))
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(
                f'{path}: line {number} is no place of an atlas ({error!r}); without it the rest '
                'can be used'
            ) from None
        found[chance.place] = chance
    return list(found.values())


def _line(data: object) -> str:
    return json.dumps(data, ensure_ascii=False, allow_nan=False) + '\n'


def _as_json(chance: PlaceChance) -> dict[str, Any]:
    return {
        'ball': chance.place.ball,
        'ball_place': chance.place.ball_place,
        'cue_place': chance.place.cue_place,
        'status': chance.status.name,
        'message': chance.message,
        'success': chance.success,
        'interval': chance.interval,
        'successes': chance.successes,
        'trials': chance.trials,
        'simulations': chance.simulations,
        'kind': chance.kind,
        'stroke': chance.stroke and dict(zip(OFFSETS, chance.stroke, strict=True)),
    }


def _from_json(data: Mapping[str, Any]) -> PlaceChance:
    (ball_x, ball_y), (cue_x, cue_y) = data['ball_place'], data['cue_place']
    stroke = data['stroke']
    return PlaceChance(
        Place(data['ball'], (ball_x, ball_y), (cue_x, cue_y)),
        Status[data['status']],
        data['message'],
        data['successes'],
        data['trials'],
        data['simulations'],
        data['kind'],
        stroke and tuple(stroke[name] for name in OFFSETS),
    )
