"""Options for strokes, for all commands that take strokes."""

import argparse
from pathlib import Path
from typing import Any

from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke


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
        ('elevation-deg', 'downward angle of the stroke (default: 0)'),
        ('azimuth-deg', 'direction, counter-clockwise from +x (default: 0)'),
        ('speed', 'speed of the cue (m/s)'),
    ):
        short = SHORT[name]
        offsets.add_argument(f'-{short}', f'--{name}', type=float, metavar='NUMBER', help=text)


# Short options; z as in azimuth.
SHORT = {'a': 'a', 'b': 'b', 'elevation-deg': 'e', 'azimuth-deg': 'z', 'speed': 's'}
NAMES = 'normal', 'velocity', 'a', 'b', 'elevation_deg', 'azimuth_deg', 'speed'


def strokes_given(options: argparse.Namespace) -> bool:
    """Whether any stroke is given."""
    return bool(options.strokes) or bool(_given(options))


def _given(options: argparse.Namespace) -> dict[str, Any]:
    return {name: value for name in NAMES if (value := getattr(options, name)) is not None}


def strokes_of(options: argparse.Namespace, scene: Scene) -> dict[str, Stroke]:
    """Strokes by name; ValueError if none is given, or if they are given in two ways."""
    from billiard_shot.shot.stroke_file import read_strokes, stroke_from

    given = _given(options)
    if options.strokes and given:
        raise ValueError('--strokes: is not allowed together with a stroke on the command line')
    if options.strokes:
        return read_strokes(options.strokes, scene.cue_ball)
    if not given:
        raise ValueError('stroke: missing; give --strokes, --normal and --velocity, or --speed')
    return {'1': stroke_from(given, scene.cue_ball)}
