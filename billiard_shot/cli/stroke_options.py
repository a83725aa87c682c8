"""Options for strokes, for all commands that take strokes."""

import argparse
from dataclasses import dataclass, fields
from pathlib import Path
import re
from typing import Any, ClassVar

from billiard_shot.cli.options import option
from billiard_shot.scene import Scene
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
