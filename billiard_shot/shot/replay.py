"""
Shots as JSON: what was asked for and what came out, read back exactly.

A file holds the scene with all its defaults, the stroke, the tolerance, and every number of the
result, each double in the shortest decimal form that reads back as the same double. Infinities and
NaNs, which JSON lacks, are written as {"float": "inf"}. An array of records is an object with an
array for each field.
"""

from collections.abc import Mapping
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.state import PhaseLog
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import reason
from billiard_shot.scene.fields import check_type
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.model.cue import CueRecord
from billiard_shot.table.model.motion import EventRecord, SegmentRecord
from billiard_shot.table.run.results import EventLog, TableRun

REPLAY_FORMAT, VERSION = 'billiard_shot shot', 2


def to_json(shot: Shot) -> str:
    """Write a shot as one line of JSON."""
    check_type('shot', shot, Shot)
    text = json.dumps(_plain(_record(shot)), allow_nan=False, ensure_ascii=False)
    return text + '\n'


def from_json(text: str) -> Shot:
    """
    Read a shot back.

    Raises
    ------
    ValueError
        If the text is not the record of a shot, or has another version.

    """
    try:
        data = json.loads(text, object_hook=_special)
    except (json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f'shot must be JSON: {error}') from None
    if not isinstance(data, dict) or data.get('format') != REPLAY_FORMAT:
        raise ValueError(f'format must be {REPLAY_FORMAT!r}: this is not a shot')
    if data.get('version') != VERSION:
        raise ValueError(f'version must be {VERSION}, got {data.get("version")!r}')
    try:
        return _shot(data)
    except (KeyError, IndexError, TypeError, AttributeError, OverflowError) as error:
        raise ValueError(f'shot: incomplete or damaged: {type(error).__name__} {error}') from None


def save_shot(shot: Shot, path: str | Path) -> None:
    """
    Write a shot to a file of JSON, from which `load_shot` reads it back exactly.

    Infinities and NaNs, which JSON lacks, are written as `{"float": "inf"}`. An array of records
    is an object with an array for each field of the record. The keys are:

    - `format`, `version`: `billiard_shot shot`, 2.
    - `scene`: as in the YAML file of a scene, with all defaults.
    - `stroke`: `normal` and `velocity` [m/s], frame `table`; `axis`, whether the normal is where
      the axis of the cue meets the ball.
    - `position`: of the cue ball before the strike [m].
    - `tolerance` [m]; `wall_time` of the prediction [s].
    - `status`: name of a `Status`; `message`, for people, which is not read back.
    - `error_estimate`: largest error of the trajectory [m].
    - `discontinuity`: distance between the two resting places that law `energetic` allows [m].
    - `run`: every ball, with names, segments and events (fields of `SegmentRecord` and of
      `EventRecord` in table/model/motion.py).
    - `strike`: fields of `CueRecord` in table/model/cue.py, such as `velocity` [m/s], `spin`
      [rad/s], `impulses` [N s] and `miscue`.
    - `phases`, `losses`: of the strike, fields of `PhaseLog` in impact/state.py, and [J].

    Parameters
    ----------
    shot : Shot
    path : str or Path

    Raises
    ------
    ValueError
        If the file cannot be written.

    """
    text = to_json(shot)
    try:
        Path(path).write_text(text, encoding='utf-8')
    except (OSError, TypeError) as error:
        raise ValueError(f'{path}: {reason(error)}') from None


def load_shot(path: str | Path) -> Shot:
    """Read a shot from a file; ValueError says which file, and what is wrong with it."""
    try:
        return from_json(Path(path).read_text(encoding='utf-8'))
    except (OSError, TypeError, ValueError) as error:
        raise ValueError(f'{path}: {reason(error)}') from None


def _record(shot: Shot) -> dict[str, Any]:
    stroke, run = shot.stroke, shot.run
    return {
        'format': REPLAY_FORMAT,
        'version': VERSION,
        'message': shot.message,  # for people, not read back
        'scene': shot.scene.to_dict(derived=True),
        'stroke': {
            'normal': stroke.normal,
            'velocity': stroke.velocity,
            'axis': stroke.axis,
            'miss': stroke.miss,
        },
        'position': shot.position,
        'tolerance': shot.tolerance,
        'wall_time': shot.wall_time,
        'status': shot.status.name,
        'error_estimate': shot.error_estimate,
        'discontinuity': shot.discontinuity,
        'run': {
            'names': run.names,
            'status': run.status.name,
            'duration': run.duration,
            'wall_time': run.wall_time,
            'searches': run.searches,
            'jaws_met': run.jaws_met,
            'segments': _columns(run._segments),
            'events': _columns(run._events.rows),
            'participants': run._events.participants,
            'places': run._places,
        },
        'strike': _columns(shot._cue),
        'phases': _columns(shot._log),
        'losses': shot._losses,
    }


def _shot(data: dict[str, Any]) -> Shot:
    known = {name: [value] for name, value in data['strike'].items()}
    strike = _rows(CueRecord, known, 'strike')
    strike.flags.writeable = False
    losses = np.array(data['losses'], dtype=float).reshape(-1, 2)
    return Shot(
        scene=Scene.from_dict(data['scene']),
        stroke=_stroke(data['stroke']),
        position=np.array(data['position'], dtype=float),
        tolerance=data['tolerance'],
        wall_time=data['wall_time'],
        status=Status[data['status']],
        error_estimate=data['error_estimate'],
        discontinuity=data['discontinuity'],
        run=_run(data['run']),
        _cue=strike[0],
        _log=_rows(PhaseLog, data['phases'], 'phases').reshape(-1, len(losses)),
        _losses=losses,
    )


def _stroke(data: dict[str, Any]) -> Stroke:
    stroke = Stroke(data['normal'], data['velocity'], axis=data['axis'], miss=data['miss'])
    # made a unit vector once more, it may differ in its last bit
    object.__setattr__(stroke, 'normal', tuple(data['normal']))
    return stroke


def _run(data: dict[str, Any]) -> TableRun:
    participants = np.array(data['participants'], dtype=np.int64).reshape(-1, 2)
    return TableRun(
        tuple(data['names']),
        Status[data['status']],
        data['duration'],
        data['wall_time'],
        data['searches'],
        _rows(SegmentRecord, data['segments'], 'run: segments'),
        _events=EventLog(_rows(EventRecord, data['events'], 'run: events'), participants),
        _places=np.array(data['places'], dtype=np.int64),
        jaws_met=data['jaws_met'],
    )


def _columns(records: NDArray[np.void] | np.void) -> dict[str, Any]:
    """Return an array for each field of records."""
    return {name: records[name] for name in records.dtype.names or ()}


def _rows(kind: type, data: dict[str, Any], name: str) -> NDArray[np.void]:
    """Read what `_columns` wrote."""
    dtype: np.dtype[np.void] = kind.dtype  # type: ignore[attr-defined]
    names = dtype.names or ()
    columns = {field: np.array(data[field], dtype=dtype[field].base) for field in names}
    scalar = next(field for field in names if not dtype[field].shape)
    shape = columns[scalar].shape
    rows: NDArray[np.void] = np.zeros(shape, dtype)
    for field, column in columns.items():
        wanted = (*shape, *dtype[field].shape)
        if column.shape != wanted:
            raise ValueError(f'{name}: {field} must have shape {wanted}, got {column.shape}')
        rows[field] = column
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
    special = data.keys() == {'float'} and data['float'] in ('inf', '-inf', 'nan')
    return float(data['float']) if special else data
