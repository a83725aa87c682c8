"""Shots on the command line: predicted from strokes, or read from a file."""

import argparse
from pathlib import Path

from billiard_shot import load_shot, predict, Scene, Shot
from billiard_shot.shot.stroke_options import add_stroke_arguments, strokes_given, strokes_of


def add_shot_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for a recorded shot, a file of strokes, or one stroke."""
    parser.add_argument(
        'shot',
        nargs='?',
        type=Path,
        metavar='SHOT',
        help='a recorded shot (.json), or a list of strokes (.yaml)',
    )
    parser.add_argument(
        '--scene', help='scene of the strokes: bundled scene or YAML file (default: pool)'
    )
    parser.add_argument(
        '--tolerance',
        type=float,
        metavar='M',
        help='largest error of the trajectories of strokes, in metres (default: 1e-4)',
    )
    add_stroke_arguments(parser)


def shots_of(options: argparse.Namespace) -> dict[str, Shot]:
    """Shots by name; ValueError if none is given, or if they are given in two ways."""
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
    """Path of the file of a shot: FILE, or FILE-NAME if there are several shots."""
    return path if len(shots) == 1 else path.with_stem(f'{path.stem}-{name}')
