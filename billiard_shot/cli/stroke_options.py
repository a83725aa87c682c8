"""Options for strokes, for all commands that take strokes."""

import argparse
from pathlib import Path
import re
from typing import Any

from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run.results import POCKET_NAMES


def add_stroke_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for a file of strokes, or for one stroke in one of two forms."""
    file = parser.add_argument_group('strokes from a file')
    file.add_argument(
        '--strokes',
        type=Path,
        metavar='FILE.yaml',
        help='list of strokes, each with fields named like the options below: '
        '[{speed: 2, b: 0.3, elevation_deg: 5}]',
    )
    vectors = parser.add_argument_group('or one stroke by its vectors')
    for name, text in (
        ('normal', 'outward normal of the ball at the contact with the tip, any length'),
        ('velocity', 'velocity of the cue (m/s)'),
    ):
        vectors.add_argument(f'--{name}', type=float, nargs=3, metavar=('X', 'Y', 'Z'), help=text)
    offsets = parser.add_argument_group('or one stroke by its offsets and angles')
    for name, text in (
        ('a', 'offset to the right, in ball radii (default: 0)'),
        ('b', 'offset upwards, in ball radii (default: 0)'),
        (
            'elevation-deg',
            'downward angle of the stroke (default: 0; of predict and view: lowest '
            'with clearance)',
        ),
        ('azimuth-deg', 'direction, counter-clockwise from +x (default: 0)'),
        ('speed', 'speed of the cue (m/s)'),
    ):
        short = SHORT[name]
        offsets.add_argument(f'-{short}', f'--{name}', type=float, metavar='NUMBER', help=text)


def add_aim_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options that aim one stroke at a ball or a point of the scene."""
    aim = parser.add_argument_group('aim, instead of --azimuth-deg')
    aim.add_argument(
        '--aim',
        nargs='+',
        metavar=('BALL', 'Y'),
        help='ball to hit, or X Y of a point (m), without correction for throw and swerve; the '
        'default elevation leaves room for the errors of the player',
    )
    aim.add_argument(
        '--cut',
        type=float,
        metavar='DEG',
        help='cut angle; positive sends the ball to the right, as seen along the stroke '
        '(default: 0)',
    )
    aim.add_argument(
        '--pocket',
        choices=POCKET_NAMES,
        metavar='POCKET',
        help=f'cut that sends the ball into this pocket: {", ".join(POCKET_NAMES)}',
    )
    aim.add_argument(
        '--correct-squirt',
        action='store_true',
        help='turn the cue so that the cue ball leaves along the line, in spite of its side spin',
    )


# Short options; z as in azimuth.
SHORT = {'a': 'a', 'b': 'b', 'elevation-deg': 'e', 'azimuth-deg': 'z', 'speed': 's'}
NAMES = 'normal', 'velocity', 'a', 'b', 'elevation_deg', 'azimuth_deg', 'speed'


def strokes_given(options: argparse.Namespace) -> bool:
    """Whether any stroke is given."""
    return bool(options.strokes) or bool(_given(options))


def _given(options: argparse.Namespace) -> dict[str, Any]:
    names = *NAMES, 'aim'
    return {name: value for name in names if (value := getattr(options, name, None)) is not None}


def strokes_from_options(options: argparse.Namespace, scene: Scene) -> dict[str, Stroke]:
    """Strokes by name; ValueError if none is given, or if they are given in two ways."""
    from billiard_shot.shot.stroke import read_strokes, stroke_from

    given = _given(options)
    if options.strokes and given:
        raise ValueError('--strokes must not be given together with a stroke')
    if options.strokes:
        return read_strokes(options.strokes, scene.cue_ball)
    if not given:
        aim = '--aim BALL or ' if hasattr(options, 'aim') else ''
        raise ValueError(
            f'stroke is missing; give --speed and {aim}--azimuth-deg, --strokes FILE, or --normal '
            'and --velocity'
        )
    if 'aim' in given:
        return {'1': _aimed(given, options, scene)}
    for name in ('cut', 'pocket'):
        if getattr(options, name, None) is not None and not getattr(options, 'pot', None):
            raise ValueError(f'--{name} needs --aim BALL')
    return {'1': stroke_from(given, scene.cue_ball)}


def _aimed(given: dict[str, Any], options: argparse.Namespace, scene: Scene) -> Stroke:
    """Aim at the ball or point of --aim."""
    from billiard_shot.shot.aim import aim

    words = given.pop('aim')
    for name in ('normal', 'velocity', 'azimuth_deg'):
        if name in given:
            raise ValueError(f'--aim must not be given together with --{name.replace("_", "-")}')
    if 'speed' not in given:
        raise ValueError('--speed is missing; --aim needs the speed of the cue (m/s)')
    target: str | list[float] = words[0]
    if len(words) > 1 or words[0] not in scene.object_balls:
        try:
            x, y = map(float, words)
        except ValueError:
            balls = ', '.join(scene.object_balls) or 'none'
            text = (
                f'--aim must be a ball, or X Y, got {" ".join(words)} (m); the balls are: {balls}'
            )
            raise ValueError(text) from None
        target = [x, y]
    try:
        return aim(
            scene,
            target,
            cut_deg=options.cut,
            pocket=options.pocket,
            correct_squirt=options.correct_squirt,
            **given,
        )
    except ValueError as error:
        raise ValueError(re.sub(r'^(target|cut_deg|cut|pocket) ', _option, str(error))) from None


def _option(match: re.Match[str]) -> str:
    """Name of the option that gave an argument of `aim`."""
    return {'target': '--aim ', 'pocket': '--pocket '}.get(match[1], '--cut ')
