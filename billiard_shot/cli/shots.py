"""Scenes, strokes, shots and searches on the command line, the same for all commands."""

import argparse
from dataclasses import dataclass, fields
from functools import partial
import math
from pathlib import Path
import re
import sys
from typing import Any, ClassVar
from urllib.parse import urlsplit

from billiard_shot import load_shot, lowest_elevation, predict, Shot
from billiard_shot.cli.options import constant, option, positional
from billiard_shot.cli.workers import mapped, OfWork
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.fields import number, whole_number
from billiard_shot.scene.files import read_yaml, scene_names
from billiard_shot.scene.player import NOISES
from billiard_shot.shot.play import DEFAULT_SHOT_TOLERANCE
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.run.results import POCKET_NAMES


@dataclass(frozen=True)
class OfStrokesFile:
    """
    A file of strokes.

    Parameters
    ----------
    strokes : FILE.yaml
        List of strokes, such as [{speed: 2, b: 0.3, elevation_deg: 5}], each with fields named
        like the options below.

    """

    TITLE: ClassVar = 'strokes from a file'
    strokes: Path | None = None


@dataclass(frozen=True)
class OfVectors:
    """
    One stroke by its vectors.

    Parameters
    ----------
    normal : X Y Z
        Outward normal of the ball at the contact with the tip, any length.
    velocity : X Y Z
        Velocity of the cue (m/s).

    """

    TITLE: ClassVar = 'or one stroke by its vectors'
    normal: tuple[float, float, float] | None = None
    velocity: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class OfOffsets:
    """
    One stroke by its offsets and angles; z as in azimuth.

    Parameters
    ----------
    a : NUMBER
        Offset to the right, in ball radii (default: 0).
    b : NUMBER
        Offset upwards, in ball radii (default: 0).
    elevation_deg : NUMBER
        Downward angle of the stroke (default: 0; of predict and view: lowest with clearance).
    azimuth_deg : NUMBER
        Direction, counter-clockwise from +x (default: 0).
    speed : NUMBER
        Speed of the cue (m/s).

    """

    TITLE: ClassVar = 'or one stroke by its offsets and angles'
    a: float | None = option('-a')
    b: float | None = option('-b')
    elevation_deg: float | None = option('-e')
    azimuth_deg: float | None = option('-z')
    speed: float | None = option('-s')


@dataclass(frozen=True)
class OfAim:
    """
    One stroke at a ball or a point of the scene.

    Parameters
    ----------
    aim : BALL Y
        Ball to hit, or X Y of a point (m), without correction for throw and swerve; the default
        elevation leaves room for the errors of the player.
    cut : DEG
        Cut angle; positive sends the ball to the right, as seen along the stroke (default: 0).
    pocket : POCKET
        Cut that sends the ball into this pocket: %(choices)s.
    correct_squirt : bool
        Turn the cue so that the cue ball leaves along the line, in spite of its side spin.

    """

    TITLE: ClassVar = 'aim, instead of --azimuth-deg'
    aim: list[str] | None = None
    cut: float | None = None
    pocket: str | None = option(choices=POCKET_NAMES)
    correct_squirt: bool = False


STROKE_OPTIONS = OfStrokesFile(), OfVectors(), OfOffsets()
"""For a file of strokes, or for one stroke in one of two forms."""

NAMES = tuple(field.name for kind in (OfVectors, OfOffsets) for field in fields(kind))


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
