"""Scenes, strokes and shots on the command line, the same for all commands."""

import argparse
from functools import partial
import math
from pathlib import Path
import sys

from billiard_shot import load_shot, lowest_elevation, predict, Scene, Shot, Stroke
from billiard_shot.cli.workers import add_work_arguments, mapped
from billiard_shot.scene.bundled import scene_names
from billiard_shot.scene.yaml_file import read_yaml
from billiard_shot.shot.accuracy import DEFAULT_SHOT_TOLERANCE
from billiard_shot.shot.stroke_options import (
    add_aim_arguments,
    add_stroke_arguments,
    strokes_from_options,
    strokes_given,
)


def add_scene_argument(
    parser: argparse.ArgumentParser, default: str | None = None, also: str = ''
) -> None:
    """Add the scene, which comes first in all commands; without a default, it is required."""
    ending = f' (default: {default})' if default else ''
    parser.add_argument(
        'scene',
        nargs='?',
        metavar='SCENE',
        help=f'bundled scene (see `billiard-shot scene list`) or YAML file{also}{ending}',
    )
    parser.add_argument('--scene', dest='scene_option', metavar='SCENE', help=argparse.SUPPRESS)
    parser.set_defaults(default_scene=default)


def add_shot_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for a recorded shot, or for a scene with a file of strokes or one stroke."""
    add_scene_argument(parser, 'pool', ', or a recorded shot (.json)')
    parser.add_argument(
        '-t',
        '--tolerance',
        type=float,
        metavar='M',
        help=f'largest error of the trajectories, in metres (default: {DEFAULT_SHOT_TOLERANCE:g})',
    )
    add_aim_arguments(parser)
    add_stroke_arguments(parser)
    add_work_arguments(parser)


def scene_name(options: argparse.Namespace) -> str:
    """
    Name or path of the scene.

    A file with a list of strokes in the place of the scene is taken as --strokes.
    """
    first, named = options.scene, options.scene_option
    if (
        first
        and hasattr(options, 'strokes')
        and Path(first).suffix in ('.yaml', '.yml')
        and isinstance(read_yaml(Path(first)), list)
    ):
        if strokes_given(options):
            raise ValueError('--strokes must not be given together with a stroke')
        options.strokes, first = Path(first), None
    if first and named:
        raise ValueError(f'--scene must not be given together with scene {first}')
    name = first or named or options.default_scene
    if name is None:
        raise ValueError(
            f'SCENE is missing; it must be a YAML file or one of {", ".join(scene_names())}'
        )
    return str(name)


def shots_of(options: argparse.Namespace) -> dict[str, Shot]:
    """Shots by name; ValueError if none is given, or if they are given in two ways."""
    if options.scene and Path(options.scene).suffix == '.json':
        path = Path(options.scene)
        if strokes_given(options):
            raise ValueError(
                f'SCENE must be a scene together with a stroke, got the recorded shot {path}'
            )
        for name, value in (('scene', options.scene_option), ('tolerance', options.tolerance)):
            if value is not None:
                raise ValueError(
                    f'--{name} must not be given together with a recorded shot, which has one'
                )
        return {path.stem: load_shot(path)}
    scene = Scene.load(scene_name(options))
    tolerance = DEFAULT_SHOT_TOLERANCE if options.tolerance is None else options.tolerance
    strokes = strokes_from_options(options, scene)
    if not (options.strokes or options.normal or options.aim) and options.elevation_deg is None:
        strokes = {name: _with_clearance(scene, stroke) for name, stroke in strokes.items()}
    work = partial(predict, scene, tolerance=tolerance)
    shots = mapped(options, work, list(strokes.values()))
    return dict(zip(strokes, shots, strict=True))


def _with_clearance(scene: Scene, stroke: Stroke) -> Stroke:
    """Raise a level cue as far as it needs, and say so on stderr."""
    a, b, _, azimuth, speed = stroke.offsets
    elevation = float(lowest_elevation(scene, [stroke.offsets])[0])
    if not 0.0 < elevation < math.inf:
        return stroke
    print(
        f'elevation {math.degrees(elevation):.4g}°: the lowest at which the cue has clearance; '
        'another one: --elevation-deg',
        file=sys.stderr,
    )
    return Stroke.from_offsets(a, b, elevation, azimuth, speed)


def of_each(path: Path, name: str, shots: dict[str, Shot]) -> Path:
    """Path of the file of a shot: FILE, or FILE-NAME if there are several shots."""
    return path if len(shots) == 1 else path.with_stem(f'{path.stem}-{name}')


def title_of(name: str, text: str, shots: dict[str, Shot]) -> str:
    """Text about a shot, with the name of its stroke if there are several."""
    return text if len(shots) == 1 else f'stroke {name}: {text}'
