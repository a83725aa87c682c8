"""Shots on the command line: predicted from strokes, or recorded in a file."""

import argparse
from pathlib import Path

from billiard_shot import load_shot, predict, Scene, Shot
from billiard_shot.shot.stroke_options import add_stroke_arguments, strokes_given, strokes_of


def add_shot_arguments(parser: argparse.ArgumentParser) -> None:
    """Let the command take a recorded shot, a file of strokes, or one stroke."""
    parser.add_argument(
        'shot',
        nargs='?',
        type=Path,
        metavar='SHOT',
        help='a recorded shot (.json), or a list of strokes (.yaml)',
    )
    parser.add_argument('--scene', help='of strokes: bundled scene or YAML file (pool)')
    parser.add_argument(
        '--tolerance',
        type=float,
        metavar='M',
        help='of strokes: largest error of the trajectory in metres (1e-4)',
    )
    add_stroke_arguments(parser)


def shots_of(options: argparse.Namespace) -> dict[str, Shot]:
    """Shots by name; ValueError if none is stated, or more than one way is used."""
    if options.shot:
        if strokes_given(options):
            raise ValueError(
                f'SHOT: {options.shot} is not allowed together with a stroke by other options'
            )
        if options.shot.suffix == '.json':
            for name in ('scene', 'tolerance'):
                if getattr(options, name) is not None:
                    raise ValueError(
                        f'--{name}: is not allowed together with a recorded shot, which has one'
                    )
            return {options.shot.stem: load_shot(options.shot)}
        options.strokes = options.shot
    scene = Scene.load(options.scene or 'pool')
    tolerance = 1e-4 if options.tolerance is None else options.tolerance
    strokes = strokes_of(options, scene)
    return {name: predict(scene, stroke, tolerance) for name, stroke in strokes.items()}


def of_each(path: Path, name: str, shots: dict[str, Shot]) -> Path:
    """Name of a file for one of the shots: FILE itself, or FILE-NAME where there are several."""
    return path if len(shots) == 1 else path.with_stem(f'{path.stem}-{name}')
