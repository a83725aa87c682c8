"""`billiard-shot ...`: predictions for people without ROS."""
import argparse
from collections.abc import Sequence
import json
from pathlib import Path
import sys
from typing import Any

import billiard_shot
from billiard_shot import Scene, Shot, Stroke


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; return 0, 1 if a stroke was refused, or 2 if the input is wrong."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.run(options))
    except ValueError as error:
        print(f'billiard-shot: {error}', file=sys.stderr)
        return 2


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='billiard-shot', description=billiard_shot.__doc__)
    commands = parser.add_subparsers(required=True, metavar='COMMAND')
    _add_predict(commands)
    return parser


def _add_predict(commands: Any) -> None:
    parser = commands.add_parser('predict', help='what a stroke does to the cue ball')
    parser.set_defaults(run=_predict)
    parser.add_argument('--scene', default='pool', help='bundled scene or YAML file (%(default)s)')
    parser.add_argument('--tolerance', type=float, default=1e-4, metavar='M',
                        help='largest error of the trajectory in metres (%(default)g)')
    parser.add_argument('--json', action='store_true', help='one JSON object a line, in SI units')
    file = parser.add_argument_group('strokes from a file')
    file.add_argument('--strokes', type=Path, metavar='FILE.yaml', help='a list of strokes')
    vectors = parser.add_argument_group('or one stroke by its vectors')
    for name, text in (('normal', 'outward normal where the tip hits, any length'),
                       ('velocity', 'of the cue in m/s')):
        vectors.add_argument(f'--{name}', type=float, nargs=3, metavar=('X', 'Y', 'Z'), help=text)
    offsets = parser.add_argument_group('or one stroke as players say it')
    for name, text in (('a', 'offset to the right in ball radii (0)'),
                       ('b', 'offset up in ball radii (0)'),
                       ('elevation-deg', 'angle by which the stroke points down (0)'),
                       ('azimuth-deg', 'direction, counter-clockwise from +x (0)'),
                       ('speed', 'of the cue in m/s')):
        offsets.add_argument(f'--{name}', type=float, metavar='NUMBER', help=text)


def _predict(options: argparse.Namespace) -> int:
    scene = Scene.load(options.scene)
    strokes = _strokes(options, scene)
    shots = {name: billiard_shot.predict(scene, stroke, options.tolerance)
             for name, stroke in strokes.items()}
    if options.json:
        for name, shot in shots.items():
            print(json.dumps(_as_json(name, shot), allow_nan=False, ensure_ascii=False))
    else:
        print(_as_table(shots))
    for name, shot in shots.items():
        if shot.status.refused:
            print(f'stroke {name}: {shot.status.name}: {shot.message}', file=sys.stderr)
    return 1 if any(shot.status.refused for shot in shots.values()) else 0


def _strokes(options: argparse.Namespace, scene: Scene) -> dict[str, Stroke]:
    from billiard_shot.shot.stroke_file import read_strokes, stroke_from

    names = 'normal', 'velocity', 'a', 'b', 'elevation_deg', 'azimuth_deg', 'speed'
    given = {name: value for name in names if (value := getattr(options, name)) is not None}
    if options.strokes and given:
        raise ValueError('--strokes: is not allowed together with a stroke on the command line')
    if options.strokes:
        return read_strokes(options.strokes, scene.cue_ball)
    if not given:
        raise ValueError('stroke: missing; give --strokes, --normal and --velocity, or --speed')
    return {'1': stroke_from(given, scene.cue_ball)}


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
        'rest': shot.trajectory.rest.tolist(),
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
        rows.append((
            name, shot.status.name, _numbers(shot.velocity, 4), _numbers(shot.spin, 3),
            _numbers([shot.cue_speed], 4), _numbers(path.rest[:2], 4),
            _numbers([path.duration], 2), f'{1e3 * shot.error_estimate:.1g}',
        ))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return '\n'.join(
        '  '.join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )


def _numbers(values: Any, digits: int) -> str:
    # + 0.0 makes 0 of -0
    texts = (f'{round(value, digits) + 0.0:.{digits}f}' for value in values)
    return ' '.join(text.rjust(digits + 4) for text in texts)


if __name__ == '__main__':
    sys.exit(main())
