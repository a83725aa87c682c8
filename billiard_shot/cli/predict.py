"""`billiard-shot predict`: predict the shot of a stroke."""

import argparse
import json
from pathlib import Path
import sys
from typing import Any

from billiard_shot import save_shot, Shot
from billiard_shot.cli.shots import add_shot_arguments, of_each, shots_of
from billiard_shot.cli.text_table import numbers, table
from billiard_shot.pictures.canvas import require_matplotlib
from billiard_shot.pictures.history import draw_history
from billiard_shot.pictures.strike import draw_strike
from billiard_shot.pictures.table import draw_shot
from billiard_shot.pictures.trails import trails_of

HELP = 'predict the motion of the cue ball after a stroke'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for shots and output."""
    parser.add_argument(
        '--json', action='store_true', help='print one JSON object per line, in SI units'
    )
    add_shot_arguments(parser)
    files = parser.add_argument_group('files; FILE-NAME for each of several strokes')
    files.add_argument(
        '--output',
        '--save',  # its former name
        type=Path,
        metavar='FILE.json',
        help='write the shot: the complete input and result',
    )
    for name, text in (
        ('picture', 'the table from above'),
        ('history', 'speed, spin and energy over time'),
        ('close-up', 'the strike: forces, friction, slip and energy'),
    ):
        files.add_argument(f'--{name}', type=Path, metavar='FILE.png', help=f'draw {text}')


def run(options: argparse.Namespace) -> int:
    """Predict and print; 1 if a stroke was refused."""
    if options.picture or options.history or options.close_up:
        require_matplotlib()  # before the work, not after it
    shots = shots_of(options)
    if options.json:
        for name, shot in shots.items():
            print(json.dumps(_as_json(name, shot), allow_nan=False, ensure_ascii=False))
    else:
        print(_as_table(shots))
    for name, shot in shots.items():
        title = f'{shot.status.name}: {shot.message}'
        if options.output:
            save_shot(shot, of_each(options.output, name, shots))
        if options.picture:
            draw_shot(shot, of_each(options.picture, name, shots), title)
        if shot.status.refused:
            print(f'stroke {name}: {title}', file=sys.stderr)
            continue
        if options.history:
            draw_history(trails_of(shot), of_each(options.history, name, shots), title)
        if options.close_up:
            draw_strike(shot, of_each(options.close_up, name, shots), title)
    return 1 if any(shot.status.refused for shot in shots.values()) else 0


def _as_json(name: str, shot: Shot) -> dict[str, Any]:
    return {
        'stroke': name,
        'status': shot.status.name,
        'message': shot.message,
        'velocity': shot.velocity.tolist(),
        'spin': shot.spin.tolist(),
        'cue_speed': shot.cue_speed,
        'phases': [list(phase.active) for phase in shot.impact.phases],
        'dissipated': shot.impact.dissipated.tolist(),
        'rest': shot.trajectory.final_position.tolist(),
        'duration': shot.trajectory.duration,
        'events': [
            {'time': event.time, 'kind': event.kind, 'position': event.position.tolist()}
            for event in shot.trajectory.events
        ],
        'effects': [
            {'name': effect.name, 'simulated': effect.simulated, 'reason': effect.reason}
            for effect in shot.effects
        ],
        'error_estimate': shot.error_estimate,
        'evaluations': shot.evaluations,
        'wall_time': shot.wall_time,
    }


def _as_table(shots: dict[str, Shot]) -> str:
    rows = [
        ('stroke', 'status', 'velocity', 'spin', 'cue', 'rests at', 'after', 'error'),
        ('', '', 'x y z (m/s)', 'x y z (rad/s)', '(m/s)', 'x y (m)', '(s)', '(mm)'),
    ]
    for name, shot in shots.items():
        path = shot.trajectory
        rows.append(
            (
                name,
                shot.status.name,
                numbers(shot.velocity, 4),
                numbers(shot.spin, 3),
                numbers([shot.cue_speed], 4),
                numbers(path.final_position[:2], 4),
                numbers([path.duration], 2),
                f'{1e3 * shot.error_estimate:.1g}',
            )
        )
    return table(rows)
