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

from billiard_shot.impact.collide import CollisionResult, Ending, impulses_of, Phase
from billiard_shot.impact.state import PhaseLog
from billiard_shot.records import ROWS
from billiard_shot.scene import Scene
from billiard_shot.scene.checks import with_present_keys
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.values import check_type
from billiard_shot.shot.discontinuity import discontinuities_of_law
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.play import decide
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.strike import Strike
from billiard_shot.shot.stroke import Stroke
from billiard_shot.status import Status
from billiard_shot.table.run import EVENT_COLUMNS, events_from_columns, events_to_columns, TableRun
from billiard_shot.table.trajectory import (
    SEGMENT_COLUMNS,
    segments_from_columns,
    segments_to_columns,
    Trajectory,
)

FORMAT, VERSION = 'billiard_shot shot', 4
# Version 1 has no discontinuity and no margin: they are found again. Versions 1 and 2 know no
# double hits. Versions 1 to 3 do not say which ball was met during the strike.
READABLE = 1, 2, 3, 4
DOUBLE_HITS, MET_IN_STRIKE = 3, 4  # the first versions with these
# Keys of the file, and the fields of `Strike`.
FIELDS: Mapping[str, str] = {
    'velocity': 'velocity',
    'spin': 'spin',
    'rest': 'final_position',
    'cue_speed': 'cue_speed',
    'duration': 'duration',
    'error': 'error',
    'loss': 'losses',
    'impulse': 'impulses',
    'status': 'status',
    'phases': 'phases',
    'evaluations': 'steps',
    'segments': 'segments',
    'axes': 'axes',
    'discontinuity_margin': 'discontinuity_margin',
    'tip': 'tip',
    'again': 'again',
    'hits': 'hits',
}
LOG_COLUMNS = 12  # of a phase: ending, contact, active (2), impulses (6), energies (2)


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
        If it is no such record, or one of another version, saying what is wrong.

    """
    try:
        data = json.loads(text, object_hook=_special)
    except (json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f'shot: is no JSON: {error}') from None
    if not isinstance(data, dict) or data.get('format') != FORMAT:
        raise ValueError(f'format: missing or not {FORMAT!r}: this is no record of a shot')
    if data.get('version') not in READABLE:
        raise ValueError(
            f'version: {data.get("version")!r} is not allowed; it must be one of '
            f'{", ".join(map(str, READABLE))}'
        )
    try:
        return _shot(data)
    except (KeyError, IndexError, TypeError, AttributeError, OverflowError) as error:
        raise ValueError(f'shot: incomplete or damaged: {type(error).__name__} {error}') from None


def save_shot(shot: Shot, path: str | Path) -> None:
    """Write a shot to a file; ValueError if that cannot be done."""
    text = to_json(shot)
    try:
        Path(path).write_text(text, encoding='utf-8')
    except (OSError, TypeError) as error:
        raise ValueError(f'{path}: {error}') from None


def load_shot(path: str | Path) -> Shot:
    """Read a shot from a file; ValueError says which file, and what is wrong with it."""
    try:
        return from_json(Path(path).read_text(encoding='utf-8'))
    except (OSError, TypeError, ValueError) as error:
        raise ValueError(f'{path}: {error}') from None


def _record(shot: Shot) -> dict[str, Any]:
    stroke, table, together = shot.stroke, shot.table, shot._group
    return {
        'format': FORMAT,
        'version': VERSION,
        'status': shot.status.name,  # this and the message: for people, not read back
        'message': shot.message,
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
        'discontinuity': shot.discontinuity,
        'strike': {key: shot._strike[field] for key, field in FIELDS.items()},
        'phases': _log_columns(shot._log),
        'trajectory': None if table else segments_to_columns(shot.trajectory.rows)[:, :-1],
        'table': table
        and {
            'names': table.names,
            'status': int(table.status),
            'duration': table.duration,
            'wall_time': table.wall_time,
            'searches': table.searches,
            'jaws_met': table.jaws_met,
            'segments': segments_to_columns(table._segments),
            'events': events_to_columns(table._events),
            'places': table._places,
            'participants': table._events.participants,
        },
        'together': together
        and {
            'status': int(together.status),
            'velocities': together.velocities,
            'spins': together.spins,
            'impulses': together.impulses,
            'dissipated': together.dissipated,
            'slips': together.slips,
            'lengths': together.lengths,
            'duration': together.duration,
            'evaluations': together.evaluations,
            'phases': [
                {
                    'active': phase.active,
                    'ending': int(phase.ending),
                    'contact': phase.contact,
                    'impulses': phase.impulses,
                    'energies': phase.energies,
                }
                for phase in together.phases
            ],
        },
    }


def _shot(data: dict[str, Any]) -> Shot:
    strikes = ROWS.records(Strike, 1)
    for key, field in FIELDS.items():
        strikes[field] = (
            data['strike'].get(key, 0.0) if data['version'] < DOUBLE_HITS else data['strike'][key]
        )
    scene, stroke, tolerance = _scene(data), _stroke(data['stroke']), data['tolerance']
    position = np.array(data['position'], dtype=float)
    group = _together(data['together']) if data['together'] else None
    discontinuity = data.get('discontinuity', 0.0)
    if data['version'] == 1 and group is None:
        discontinuity = _find_discontinuity(scene, stroke, position, tolerance, strikes)
    strikes.flags.writeable = False
    table = _table(data['table']) if data['table'] else None
    if table and group and data['version'] < MET_IN_STRIKE:
        _note_first_met(table)
    trajectory = (
        table.balls[CUE_BALL]
        if table
        else Trajectory(
            segments_from_columns(_rows('trajectory', data['trajectory'], SEGMENT_COLUMNS))
        )
    )
    return Shot(
        scene,
        stroke,
        position,
        tolerance,
        data['wall_time'],
        trajectory,
        table,
        discontinuity,
        strikes[0],
        _log_rows(_rows('phases', data['phases'], LOG_COLUMNS)),
        group,
    )


def _find_discontinuity(
    scene: Scene,
    stroke: Stroke,
    position: NDArray[np.float64],
    tolerance: float,
    strikes: NDArray[np.void],
) -> float:
    """Find the discontinuity of a shot that was written without it, and complete its strike."""
    model = model_of(scene)
    found = discontinuities_of_law(
        model,
        np.array([stroke.touching(model.tip_curvature).normal]),
        np.array([stroke.velocity]),
        position,
        tolerance,
        strikes,
    )
    decide(strikes, found, None)
    return float(found[0])


def _scene(data: dict[str, Any]) -> Scene:
    scene = with_present_keys(Scene, data['scene'], warn=False)
    if data['version'] < DOUBLE_HITS:
        scene.setdefault('effects', {})['double_hit'] = 'off'
    if data['version'] == 1:  # when contacts took no time
        scene['contacts']['ball_ball'].setdefault('duration', 0.0)
        if scene.get('table') is not None:
            for key in ('duration', 'fading'):
                scene['table']['cushion'].setdefault(key, 0.0)
    return Scene.from_dict(scene)


def _stroke(data: dict[str, Any]) -> Stroke:
    stroke = Stroke(data['normal'], data['velocity'], axis=data['axis'], miss=data['miss'])
    # made a unit vector once more, it may differ in its last bit
    object.__setattr__(stroke, 'normal', tuple(data['normal']))
    return stroke


def _table(data: dict[str, Any]) -> TableRun:
    events = events_from_columns(_rows('table: events', data['events'], EVENT_COLUMNS))
    if 'participants' in data:  # not in version 1, whose events tell of 53 balls at most
        members = np.array(data['participants'], dtype=np.int64).reshape(-1, 2)
        events = events._replace(participants=members)
    return TableRun(
        tuple(data['names']),
        Status(data['status']),
        data['duration'],
        data['wall_time'],
        data['searches'],
        segments_from_columns(_rows('table: segments', data['segments'], SEGMENT_COLUMNS + 1)),
        events,
        np.array(data['places'], dtype=np.int64),
        data.get('jaws_met', 0),  # not in earlier versions
    )


def _note_first_met(table: TableRun) -> None:
    """Note the ball that the strike made fastest as the one that the cue ball met first."""
    speeds = [np.linalg.norm(ball.at(0.0).velocity) for ball in table.balls.values()][1:]
    if max(speeds, default=0.0) > 0.0:
        table._places[0, 1] = 1 + np.argmax(speeds)


def _together(data: dict[str, Any]) -> CollisionResult:
    arrays: Any = {
        name: np.array(data[name], dtype=float)
        for name in ('velocities', 'spins', 'impulses', 'dissipated', 'slips')
    }
    lengths = np.array(data.get('lengths', np.zeros(len(arrays['slips']))), dtype=float)
    phases = tuple(
        Phase(
            tuple(phase['active']),
            Ending(phase['ending']),
            phase['contact'],
            np.array(phase['impulses'], dtype=float),
            np.array(phase['energies'], dtype=float),
        )
        for phase in data['phases']
    )
    return CollisionResult(
        Status(data['status']),
        **arrays,
        lengths=lengths,
        duration=data.get('duration', 0.0),
        phases=phases,
        evaluations=data['evaluations'],
    )


def _log_columns(log: NDArray[np.void]) -> NDArray[np.float64]:
    """Write phases (phases, 2) of PhaseLog as columns."""
    return np.column_stack(
        [
            log['ending'][:, :1],
            log['contact'][:, :1],
            log['active'],
            impulses_of(log).reshape(-1, 6),
            log['energy'],
        ]
    )


def _log_rows(columns: NDArray[np.float64]) -> NDArray[np.void]:
    """Read what `_log_columns` wrote."""
    log = ROWS.records(PhaseLog, 2 * len(columns)).reshape(-1, 2)
    log['ending'], log['contact'] = columns[:, :1], columns[:, 1:2]
    log['active'], log['energy'] = columns[:, 2:4], columns[:, 10:]
    for k, field in enumerate(('impulse', 'impulse_1', 'impulse_2')):
        log[field] = columns[:, 4 + k : 10 : 3]
    return log


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
    special = data.keys() == {'float'} and data['float'] in ('inf', '-inf', 'nan')
    return float(data['float']) if special else data
