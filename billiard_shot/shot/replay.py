"""
Shots as JSON: what was asked for and what came out, read back exactly.

A record holds the scene with all its defaults, the stroke, the tolerance, and every number of the
result, each double in the shortest decimal form that reads back as the same double. What cannot be
written in JSON, an infinite number or one that is none, is the object {"float": "inf"}.
"""
from collections.abc import Mapping
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.collide import CollisionResult, Ending, Phase
from billiard_shot.scene import Scene
from billiard_shot.shot import row as at
from billiard_shot.shot.on_table import CUE
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table import motion, world
from billiard_shot.table.run import TableRun
from billiard_shot.table.trajectory import Trajectory

FORMAT, VERSION = 'billiard_shot shot', 1
# The row of a strike by names instead of columns.
FIELDS: Mapping[str, int | slice] = {
    name.lower(): column for name, column in vars(at).items()
    if name.isupper() and name != 'COLUMNS'
}
LOG_COLUMNS = 12  # of the strike of a ball alone, see kernel.solve


def to_json(shot: Shot) -> str:
    """Write a shot as one line of JSON."""
    text = json.dumps(_plain(_record(shot)), allow_nan=False, ensure_ascii=False)
    return text + '\n'


def from_json(text: str) -> Shot:
    """
    Read a shot back.

    Raises
    ------
    ValueError
        If it is no such record, or one of another version, saying what is wrong.

    """
    try:
        data = json.loads(text, object_hook=_special)
    except json.JSONDecodeError as error:
        raise ValueError(f'shot: is no JSON: {error}') from None
    if not isinstance(data, dict) or data.get('format') != FORMAT:
        raise ValueError(f'format: missing or not {FORMAT!r}: this is no record of a shot')
    if data.get('version') != VERSION:
        raise ValueError(
            f'version: {data.get("version")!r} is not allowed; it must be {VERSION}'
        )
    try:
        return _shot(data)
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f'shot: incomplete or damaged: {type(error).__name__} {error}') from None


def save_shot(shot: Shot, path: str | Path) -> None:
    """Write a shot to a file; ValueError if that cannot be done."""
    try:
        Path(path).write_text(to_json(shot), encoding='utf-8')
    except OSError as error:
        raise ValueError(f'{path}: {error}') from None


def load_shot(path: str | Path) -> Shot:
    """Read a shot from a file; ValueError says which file, and what is wrong with it."""
    try:
        return from_json(Path(path).read_text(encoding='utf-8'))
    except (OSError, ValueError) as error:
        raise ValueError(f'{path}: {error}') from None


def _record(shot: Shot) -> dict[str, Any]:
    stroke, table, together = shot.stroke, shot.table, shot._together
    return {
        'format': FORMAT,
        'version': VERSION,
        'status': shot.status.name,  # this and the message: for people, not read back
        'message': shot.message,
        'scene': shot.scene.to_dict(derived=True),
        'stroke': {
            'normal': stroke.normal, 'velocity': stroke.velocity, 'axis': stroke.axis,
            'miss': stroke.miss,
        },
        'position': shot.trajectory.at(0.0).position,  # of the cue ball, where it is struck
        'tolerance': shot.tolerance,
        'wall_time': shot.wall_time,
        'strike': {name: shot._row[column] for name, column in FIELDS.items()},
        'phases': shot._log,
        'trajectory': None if table else shot.trajectory.rows,
        'table': table and {
            'names': table.names, 'status': int(table.status), 'duration': table.duration,
            'wall_time': table.wall_time, 'searches': table.searches,
            'segments': table._segments, 'events': table._events, 'places': table._places,
        },
        'together': together and {
            'status': int(together.status), 'velocities': together.velocities,
            'spins': together.spins, 'impulses': together.impulses,
            'dissipated': together.dissipated, 'slips': together.slips,
            'evaluations': together.evaluations,
            'phases': [{
                'active': phase.active, 'ending': int(phase.ending), 'contact': phase.contact,
                'impulses': phase.impulses, 'energies': phase.energies,
            } for phase in together.phases],
        },
    }


def _shot(data: dict[str, Any]) -> Shot:
    row = np.zeros(at.COLUMNS)
    for name, column in FIELDS.items():
        row[column] = data['strike'][name]
    row.flags.writeable = False
    table = _table(data['table']) if data['table'] else None
    trajectory = table.balls[CUE] if table else Trajectory(
        _rows('trajectory', data['trajectory'], motion.COLUMNS))
    return Shot(
        Scene.from_dict(data['scene']), _stroke(data['stroke']), data['tolerance'],
        data['wall_time'], trajectory, table, row,
        _rows('phases', data['phases'], LOG_COLUMNS),
        _together(data['together']) if data['together'] else None,
    )


def _stroke(data: dict[str, Any]) -> Stroke:
    stroke = Stroke(data['normal'], data['velocity'], axis=data['axis'], miss=data['miss'])
    # made a unit vector once more, it may differ in its last bit
    object.__setattr__(stroke, 'normal', tuple(data['normal']))
    return stroke


def _table(data: dict[str, Any]) -> TableRun:
    return TableRun(
        tuple(data['names']), Status(data['status']), data['duration'], data['wall_time'],
        data['searches'], _rows('table: segments', data['segments'], motion.COLUMNS + 1),
        _rows('table: events', data['events'], world.EVENT_COLUMNS),
        np.array(data['places'], dtype=np.int64),
    )


def _together(data: dict[str, Any]) -> CollisionResult:
    arrays = {name: np.array(data[name], dtype=float)
              for name in ('velocities', 'spins', 'impulses', 'dissipated', 'slips')}
    phases = tuple(Phase(
        tuple(phase['active']), Ending(phase['ending']), phase['contact'],
        np.array(phase['impulses'], dtype=float), np.array(phase['energies'], dtype=float),
    ) for phase in data['phases'])
    return CollisionResult(
        Status(data['status']), **arrays, phases=phases, evaluations=data['evaluations']
    )


def _rows(name: str, values: Any, columns: int) -> NDArray[np.float64]:
    rows = np.array(values, dtype=float) if values else np.empty((0, columns))
    if rows.ndim != 2 or rows.shape[1] != columns:
        raise ValueError(f'{name}: shape {rows.shape} is not allowed; it must be (n, {columns})')
    return rows


def _plain(value: Any) -> Any:
    """Turn a value into what JSON can hold."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not np.isfinite(value):
        return {'float': repr(float(value))}
    return float(value) if isinstance(value, float) else value


def _special(data: dict[str, Any]) -> Any:
    """Undo what `_plain` does to numbers that JSON does not know."""
    return float(data['float']) if data.keys() == {'float'} else data
