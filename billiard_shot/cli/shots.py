"""Scenes, strokes, shots and searches on the command line, the same for all commands."""

import argparse
from functools import partial
import math
from pathlib import Path
import sys
from urllib.parse import urlsplit

from billiard_shot import load_shot, lowest_elevation, predict, Shot, Stroke
from billiard_shot.cli.stroke_options import (
    add_aim_arguments,
    add_stroke_arguments,
    strokes_from_options,
    strokes_given,
)
from billiard_shot.cli.workers import add_work_arguments, mapped
from billiard_shot.planning.within_noise import NOISES
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.files import read_yaml, scene_names
from billiard_shot.shot.play import DEFAULT_SHOT_TOLERANCE


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


def add_search_arguments(parser: argparse.ArgumentParser, budget: int, of_what: str) -> None:
    """
    Add options for noise, budget and seed.

    `budget` is the default; `of_what` completes its help text.
    """
    search = parser.add_argument_group('search')
    search.add_argument(
        '--noise',
        metavar='NAME',
        choices=[*NOISES],
        help=f'execution noise: {", ".join(NOISES)} (default: that of the scene)',
    )
    search.add_argument(
        '--noise-scale',
        type=float,
        default=1.0,
        metavar='FACTOR',
        help='factor on the noise (default: %(default)g)',
    )
    search.add_argument(
        '--budget',
        type=int,
        default=budget,
        metavar='N',
        help=f'largest number of simulated strokes{of_what} (default: {budget})',
    )
    search.add_argument(
        '--seed',
        type=int,
        default=1,
        metavar='N',
        help='seed of all random numbers (default: %(default)d)',
    )


def selected_noise(options: argparse.Namespace, scene: Scene) -> Noise:
    """Select the execution noise; ValueError if an option is invalid."""
    if not 0.0 <= options.noise_scale < math.inf:
        raise ValueError(f'--noise-scale must be at least 0, got {options.noise_scale!r}')
    noise = NOISES[options.noise] if options.noise else scene.noise
    return noise.times(options.noise_scale)


def add_site_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option."""
    parser.add_argument(
        '--site',
        default='',
        metavar='URL',
        help='address at which the page is to be published: the links that it shares lead there '
        '(default: to where the page is)',
    )


def site_of(options: argparse.Namespace) -> str:
    """Return the address; ValueError if it is not one of a page on the web."""
    parts = urlsplit(options.site)
    if options.site and not (parts.scheme in ('http', 'https') and parts.netloc):
        raise ValueError(
            f'--site must be an address, such as https://host/table.html, got {options.site!r}'
        )
    return parts._replace(fragment='').geturl()
