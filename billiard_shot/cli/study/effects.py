"""`billiard-shot study effects`: cost and influence of each effect in a shot or a scene."""

import argparse
from dataclasses import dataclass
import math
from pathlib import Path
from typing import Any

from billiard_shot import Scene
from billiard_shot.cli.options import option
from billiard_shot.cli.output import (
    Column,
    OfFormat,
    print_footer,
    print_rows,
    reporting,
    wants_text,
)
from billiard_shot.cli.shots import OfUsualScene, scene_name
from billiard_shot.cli.stroke_options import STROKE_OPTIONS, strokes_from_options, strokes_given
from billiard_shot.pictures.study import draw_effects
from billiard_shot.scene.fields import whole_number
from billiard_shot.study import comparison_count, EffectStudy, sample_strokes, study_effects
from billiard_shot.table.run.results import plural


@dataclass(frozen=True)
class OfStudy:
    """
    Tolerance, number of strokes, and picture.

    Parameters
    ----------
    tolerance : M
        Largest error of the trajectory, in metres (default: %(default)g).
    count : N
        Number of sample strokes if no stroke is given (default: %(default)d).
    picture : FILE.png
        Draw the results as bars.

    """

    tolerance: float = option('-t', default=1e-4)
    count: int = whole_number(minimum=1, default=12)
    picture: Path | None = None


OPTIONS = OfUsualScene('pool'), OfStudy(), *STROKE_OPTIONS, OfFormat()


def run(options: argparse.Namespace) -> int:
    """Measure, print, draw."""
    name = scene_name(options)
    scene = Scene.load(name)
    if strokes_given(options):
        played = list(strokes_from_options(options, scene).values())
        about = f'scene {name}, {plural(len(played), "stroke")}'
    else:
        played = sample_strokes(scene, options.count)
        about = f'scene {name}, {plural(len(played), "sample stroke")}'
    with reporting('effects', comparison_count(played)) as report:
        studies = study_effects(scene, played, options.tolerance, report=report)
    if not studies[0].changes:
        raise ValueError('strokes: none of them can be played; see billiard-shot predict')
    if wants_text(options):
        print(about)
    single = len(studies[0].changes) == 1
    if single:
        print_rows(ONE, [_of_one(study) for study in studies], options)
    else:
        print_rows(MANY, [_of_many(study) for study in studies], options)
    print_footer(COLUMNS_MEAN if single else f'{COLUMNS_MEAN} {OF_MANY}', options)
    if options.picture:
        draw_effects(studies, options.picture, about)
    return 0


COLUMNS_MEAN = (
    'Each row compares the shot with and without the effect. cost: time that the effect adds to '
    'the prediction; if it is negative, it is below the scatter of the times; steps: steps of the '
    'solver, motions and contacts that it adds; shift: distance between the resting places of the '
    "ball that moves most; turn: change of the cue ball's direction."
)
OF_MANY = 'Values are medians of the strokes that call for the effect; largest: of all strokes.'


def _of_one(study: EffectStudy) -> dict[str, Any]:
    change = study.changes[0]
    return {
        'effect': study.name,
        'simulated': change.simulated,
        'cost': change.time,
        'steps': change.steps,
        'position_change': change.distance,
        'direction_change': change.turn,
        'why': change.reason,
    }


def _of_many(study: EffectStudy) -> dict[str, Any]:
    row: dict[str, Any] = {
        'effect': study.name,
        'simulated': study.simulated,
        'strokes': len(study.changes),
        'cost': study.median('time'),
        'steps': study.median('steps'),
        'simulated_if': study.needs,
    }
    for key, field in (('position_change', 'distance'), ('direction_change', 'turn')):
        row |= {key: study.median(field), f'{key}_largest': study.largest(field)}
    return row


def _millimetres(metres: float) -> str:
    return 'endless' if math.isinf(metres) else _number(1e3 * metres)


def _degrees(radians: float) -> str:
    return _number(math.degrees(radians))


def _number(value: float) -> str:
    """Format with three digits; rounding errors are 0."""
    return '0' if abs(value) < 1e-6 else f'{value:.3g}' if abs(value) < 1e3 else f'{value:.0f}'


def _microseconds(seconds: float) -> str:
    return f'{1e6 * seconds:6.1f}'


ONE = (
    Column('effect', 'effect'),
    Column('simulated', 'on', '', lambda on: 'yes' if on else 'no'),
    Column('cost', 'cost', '(us)', _microseconds),
    Column('steps', 'steps', '', '{:4d}'.format),
    Column('position_change', 'shift', '(mm)', _millimetres),
    Column('direction_change', 'turn', '(°)', _degrees),
    Column('why', 'why'),
)
MANY = (
    Column('effect', 'effect'),
    Column('simulated', 'on in', '(strokes)'),
    Column('strokes'),
    Column('cost', 'cost', '(us)', _microseconds),
    Column('steps', 'steps', '', '{:6.1f}'.format),
    Column('position_change', 'shift', '(mm)', _millimetres),
    Column('position_change_largest', 'largest', '(mm)', _millimetres),
    Column('direction_change', 'turn', '(°)', _degrees),
    Column('direction_change_largest', 'largest', '(°)', _degrees),
    Column('simulated_if'),
)
