"""Options that say which strokes, for every command that takes some."""

import argparse
from pathlib import Path
from typing import Any

from billiard_shot.scene import Scene
from billiard_shot.shot.stroke import Stroke


def add_stroke_arguments(parser: argparse.ArgumentParser) -> None:
    """Let the command take a file of strokes, or one stroke in one of two forms."""
    file = parser.add_argument_group('strokes from a file')
    file.add_argument('--strokes', type=Path, metavar='FILE.yaml', help='a list of strokes')
    vectors = parser.add_argument_group('or one stroke by its vectors')
    for name, text in (
        ('normal', 'outward normal where the tip hits, any length'),
        ('velocity', 'of the cue in m/s'),
    ):
        vectors.add_argument(f'--{name}', type=float, nargs=3, metavar=('X', 'Y', 'Z'), help=text)
    offsets = parser.add_argument_group('or one stroke as players say it')
    for name, text in (
        ('a', 'offset to the right in ball radii (0)'),
        ('b', 'offset up in ball radii (0)'),
        ('elevation-deg', 'angle by which the stroke points down (0)'),
        ('azimuth-deg', 'direction, counter-clockwise from +x (0)'),
        ('speed', 'of the cue in m/s'),
    ):
        offsets.add_argument(f'--{name}', type=float, metavar='NUMBER', help=text)


NAMES = 'normal', 'velocity', 'a', 'b', 'elevation_deg', 'azimuth_deg', 'speed'


def strokes_given(options: argparse.Namespace) -> bool:
    """Whether any stroke is stated at all."""
    return bool(options.strokes) or bool(_given(options))


def _given(options: argparse.Namespace) -> dict[str, Any]:
    return {name: value for name in NAMES if (value := getattr(options, name)) is not None}


def strokes_of(options: argparse.Namespace, scene: Scene) -> dict[str, Stroke]:
    """Strokes by name; ValueError if none is stated, or more than one way is used."""
    from billiard_shot.shot.stroke_file import read_strokes, stroke_from

    given = _given(options)
    if options.strokes and given:
        raise ValueError('--strokes: is not allowed together with a stroke on the command line')
    if options.strokes:
        return read_strokes(options.strokes, scene.cue_ball)
    if not given:
        raise ValueError('stroke: missing; give --strokes, --normal and --velocity, or --speed')
    return {'1': stroke_from(given, scene.cue_ball)}
