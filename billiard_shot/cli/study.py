"""`billiard-shot study STUDY`: what accuracy and effects cost in a scene, to choose them."""

import argparse
from dataclasses import asdict, dataclass
import math
from pathlib import Path
from typing import Any

from billiard_shot import Scene, study
from billiard_shot.cli import output, shots
from billiard_shot.cli.options import option, Subcommand
from billiard_shot.pictures.study import draw_accuracy, draw_effects
from billiard_shot.scene.fields import whole_number
from billiard_shot.table.run.results import plural


def length(metres: float) -> str:
    """Text of a length, in mm down to 0.1 mm, then in um or nm."""
    for unit, name in ((1e-3, 'mm'), (1e-6, 'um'), (1e-9, 'nm')):
        if metres >= 0.0999 * unit:
            return f'{metres / unit:.2g} {name}'
    return f'{metres / 1e-9:.1g} nm'


def duration(seconds: float) -> str:
    """Text of a duration."""
    return f'{1e6 * seconds:.0f} us' if seconds < 1e-3 else f'{1e3 * seconds:.3g} ms'


TOLERANCE_COLUMNS = (
    output.Column('tolerance', 'tolerance', '', length),
    output.Column('typical_error', 'typical', 'error', length),
    output.Column('largest_error', 'largest', 'error', length),
    output.Column('strike', 'strike', '', duration),
    output.Column('alone', 'shot', 'alone', duration),
    output.Column('shot', 'shot', 'all balls', duration),
)


@dataclass(frozen=True)
class OfAccuracyStudy:
    """
    The picture, and the number of strokes.

    Parameters
    ----------
    picture : FILE.png
        Draw errors and times.
    count : N
        Number of random strokes (default: %(default)d).

    """

    picture: Path | None = None
    count: int = whole_number(minimum=1, default=100)


def run_accuracy(options: argparse.Namespace) -> int:
    """Compare tolerances, to choose one: measure, print, draw."""
    name = shots.scene_name(options)
    scene = Scene.load(name)
    compared = study.study_accuracy(scene, count=options.count)
    studied = list(output.progress(compared, 'accuracy', len(study.SHOT_TOLERANCES)))
    if output.wants_text(options):
        print(f'scene {name}, {options.count} random strokes')
    output.print_rows(TOLERANCE_COLUMNS, [asdict(each) for each in studied], options)
    output.print_footer(
        f'Result: {study.cost_of_accuracy(studied)}. Errors are those of the place of rest of the '
        'cue ball without the other balls. Processor times are those of a strike on endless '
        'cloth, of a shot without the other balls, and of a shot with all balls.',
        options,
    )
    if options.picture:
        draw_accuracy(studied, options.picture, f'scene {name}')
    return 0


accuracy = Subcommand(
    (shots.OfUsualScene('eight_ball'), OfAccuracyStudy(), output.OfFormat()), run_accuracy
)


@dataclass(frozen=True)
class OfEffectsStudy:
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


def run_effects(options: argparse.Namespace) -> int:
    """Measure, print, draw."""
    name = shots.scene_name(options)
    scene = Scene.load(name)
    if shots.strokes_given(options):
        played = list(shots.strokes_from_options(options, scene).values())
        about = f'scene {name}, {plural(len(played), "stroke")}'
    else:
        played = study.sample_strokes(scene, options.count)
        about = f'scene {name}, {plural(len(played), "sample stroke")}'
    with output.reporting('effects', study.comparison_count(played)) as report:
        studies = study.study_effects(scene, played, options.tolerance, report=report)
    if not studies[0].changes:
        raise ValueError('strokes: none of them can be played; see billiard-shot predict')
    if output.wants_text(options):
        print(about)
    single = len(studies[0].changes) == 1
    if single:
        output.print_rows(ONE, [_of_one(effect) for effect in studies], options)
    else:
        output.print_rows(MANY, [_of_many(effect) for effect in studies], options)
    output.print_footer(COLUMNS_MEAN if single else f'{COLUMNS_MEAN} {OF_MANY}', options)
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


def _of_one(effect: study.EffectStudy) -> dict[str, Any]:
    change = effect.changes[0]
    return {
        'effect': effect.name,
        'simulated': change.simulated,
        'cost': change.time,
        'steps': change.steps,
        'position_change': change.distance,
        'direction_change': change.turn,
        'why': change.reason,
    }


def _of_many(effect: study.EffectStudy) -> dict[str, Any]:
    row: dict[str, Any] = {
        'effect': effect.name,
        'simulated': effect.simulated,
        'strokes': len(effect.changes),
        'cost': effect.median('time'),
        'steps': effect.median('steps'),
        'simulated_if': effect.needs,
    }
    for key, field in (('position_change', 'distance'), ('direction_change', 'turn')):
        row |= {key: effect.median(field), f'{key}_largest': effect.largest(field)}
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
    output.Column('effect', 'effect'),
    output.Column('simulated', 'on', '', lambda on: 'yes' if on else 'no'),
    output.Column('cost', 'cost', '(us)', _microseconds),
    output.Column('steps', 'steps', '', '{:4d}'.format),
    output.Column('position_change', 'shift', '(mm)', _millimetres),
    output.Column('direction_change', 'turn', '(°)', _degrees),
    output.Column('why', 'why'),
)
MANY = (
    output.Column('effect', 'effect'),
    output.Column('simulated', 'on in', '(strokes)'),
    output.Column('strokes'),
    output.Column('cost', 'cost', '(us)', _microseconds),
    output.Column('steps', 'steps', '', '{:6.1f}'.format),
    output.Column('position_change', 'shift', '(mm)', _millimetres),
    output.Column('position_change_largest', 'largest', '(mm)', _millimetres),
    output.Column('direction_change', 'turn', '(°)', _degrees),
    output.Column('direction_change_largest', 'largest', '(°)', _degrees),
    output.Column('simulated_if'),
)

effects = Subcommand(
    (shots.OfUsualScene('pool'), OfEffectsStudy(), *shots.STROKE_OPTIONS, output.OfFormat()),
    run_effects,
)
