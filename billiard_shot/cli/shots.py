"""Scenes, strokes, shots and searches on the command line, the same for all commands."""

import argparse
from dataclasses import dataclass
from functools import partial
import math
from pathlib import Path
import sys
from typing import ClassVar
from urllib.parse import urlsplit

from billiard_shot import load_shot, lowest_elevation, predict, Shot, Stroke
from billiard_shot.cli.options import constant, option, positional
from billiard_shot.cli.stroke_options import (
    OfAim,
    STROKE_OPTIONS,
    strokes_from_options,
    strokes_given,
)
from billiard_shot.cli.workers import mapped, OfWork
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.fields import number, whole_number
from billiard_shot.scene.files import read_yaml, scene_names
from billiard_shot.scene.player import NOISES
from billiard_shot.shot.play import DEFAULT_SHOT_TOLERANCE


@dataclass(frozen=True)
class OfScene:
    """
    The scene, which comes first in all commands.

    Parameters
    ----------
    scene : SCENE
        Bundled scene (see `billiard-shot scene list`) or YAML file.

    """

    default_scene: str | None = constant()
    scene: str | None = positional('?')
    scene_option: str | None = option('--scene', dest='scene_option', metavar='SCENE')


@dataclass(frozen=True)
class OfUsualScene(OfScene):
    """
    The scene; without it, `default_scene`.

    Parameters
    ----------
    scene : SCENE
        Bundled scene (see `billiard-shot scene list`) or YAML file (default: %(default_scene)s).

    """


@dataclass(frozen=True)
class OfShots(OfScene):
    """
    A recorded shot, or a scene for the options of strokes.

    Parameters
    ----------
    scene : SCENE
        Bundled scene (see `billiard-shot scene list`) or YAML file, or a recorded shot (.json)
        (default: %(default_scene)s).
    tolerance : M
        Largest error of the trajectories, in metres (default: %(TOLERANCE)g).

    """

    TOLERANCE: ClassVar = DEFAULT_SHOT_TOLERANCE
    default_scene: str | None = constant('pool')
    tolerance: float | None = option('-t')


SHOT_OPTIONS = OfShots(), OfAim(), *STROKE_OPTIONS, OfWork()
"""For a recorded shot, or for a scene with a file of strokes or one stroke."""


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


@dataclass(frozen=True)
class OfNoise:
    """
    The noise and the seed.

    Parameters
    ----------
    noise : NAME
        Execution noise: %(choices)s (default: that of the scene).
    noise_scale : FACTOR
        Factor on the noise (default: %(default)g).
    seed : N
        Seed of all random numbers (default: %(default)d).

    """

    noise: str | None = option(choices=[*NOISES])
    noise_scale: float = number('', minimum=0, default=1.0)
    seed: int = whole_number(minimum=0, default=1)


def selected_noise(options: argparse.Namespace, scene: Scene) -> Noise:
    """Select the execution noise."""
    noise = NOISES[options.noise] if options.noise else scene.noise
    return noise.times(options.noise_scale)


@dataclass(frozen=True)
class OfSite:
    """
    The address of a page.

    Parameters
    ----------
    site : URL
        Address at which the page is to be published: the links that it shares lead there
        (default: to where the page is).

    """

    site: str = ''


def site_of(options: argparse.Namespace) -> str:
    """Return the address; ValueError if it is not one of a page on the web."""
    parts = urlsplit(options.site)
    if options.site and not (parts.scheme in ('http', 'https') and parts.netloc):
        raise ValueError(
            f'--site must be an address, such as https://host/table.html, got {options.site!r}'
        )
    return parts._replace(fragment='').geturl()
