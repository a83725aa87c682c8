"""`billiard-shot effects`: cost and influence of each effect in a shot or a scene."""

import argparse
from collections.abc import Sequence
import math
from pathlib import Path

from billiard_shot import Scene
from billiard_shot.cli.progress import reporting, wait_for_machine_code
from billiard_shot.cli.text_table import table
from billiard_shot.pictures.canvas import require_matplotlib
from billiard_shot.pictures.effects import draw_effects
from billiard_shot.scene.yaml_file import read_yaml
from billiard_shot.shot.stroke_options import add_stroke_arguments, strokes_given, strokes_of
from billiard_shot.study.effects import comparisons, EffectStudy, study_effects
from billiard_shot.study.sample_strokes import sample_strokes

HELP = 'measure the cost (us) and the influence (mm, degrees) of each effect in a shot or scene'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for scene, strokes and picture."""
    parser.add_argument(
        'what',
        nargs='?',
        metavar='SHOT|SCENE',
        help='YAML file with a list of strokes, or a scene (bundled, or a YAML file)',
    )
    parser.add_argument('--scene', help='scene of the strokes (default: pool)')
    parser.add_argument(
        '--tolerance',
        type=float,
        default=1e-4,
        metavar='M',
        help='largest error of the trajectory, in metres (default: %(default)g)',
    )
    parser.add_argument(
        '--count',
        type=int,
        default=12,
        metavar='N',
        help='number of sample strokes if no stroke is given (default: %(default)d)',
    )
    parser.add_argument(
        '--picture', type=Path, metavar='FILE.png', help='draw the results as bars'
    )
    add_stroke_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Measure, print, draw."""
    wait_for_machine_code()
    if options.picture:
        require_matplotlib()  # before the work, not after it
    name, strokes = _what(options)
    scene = Scene.load(name)
    if strokes or strokes_given(options):
        options.strokes = strokes or options.strokes
        played = list(strokes_of(options, scene).values())
        about = f'scene {name}, {_count(len(played), "stroke")}'
    elif options.count > 0:
        played = sample_strokes(scene, options.count)
        about = f'scene {name}, {_count(len(played), "sample stroke")}'
    else:
        raise ValueError(f'--count: {options.count} is not allowed; it must be at least 1')
    with reporting('effects', comparisons(played)) as report:
        studies = study_effects(scene, played, options.tolerance, report=report)
    if not studies[0].changes:
        raise ValueError('strokes: none of them can be played; see billiard-shot predict')
    print(about)
    print(_of_one(studies) if len(studies[0].changes) == 1 else _of_many(studies))
    if options.picture:
        draw_effects(studies, about, options.picture)
    return 0


def _what(options: argparse.Namespace) -> tuple[str, Path | None]:
    """Name of the scene, and the file of strokes if one was given."""
    path = Path(options.what or '')
    if path.suffix in ('.yaml', '.yml') and isinstance(read_yaml(path), list):
        return options.scene or 'pool', path
    if options.what and options.scene:
        raise ValueError(f'--scene: is not allowed together with scene {options.what}')
    return options.what or options.scene or 'pool', None


def _of_one(studies: Sequence[EffectStudy]) -> str:
    rows = [
        ('effect', 'simulated', 'cost', 'steps', 'position change', 'direction change', 'why'),
        ('', '', '(us)', '', '(mm)', '(degrees)', ''),
    ]
    for study in studies:
        change = study.changes[0]
        rows.append(
            (
                study.name,
                'yes' if change.simulated else 'no',
                f'{1e6 * change.time:6.1f}',
                f'{change.steps:4d}',
                _millimetres(change.distance),
                _degrees(change.turn),
                change.reason,
            )
        )
    return table(rows)


def _of_many(studies: Sequence[EffectStudy]) -> str:
    rows = [
        (
            'effect',
            'simulated',
            'cost',
            'steps',
            'position change (mm)',
            '',
            'direction change (degrees)',
            '',
            'simulated if',
        ),
        ('', 'in', '(us)', '', 'median', 'largest', 'median', 'largest', ''),
    ]
    for study in studies:
        rows.append(
            (
                study.name,
                f'{study.simulated} of {len(study.changes)}',
                f'{1e6 * study.median("time"):6.1f}',
                f'{study.median("steps"):6.1f}',
                _millimetres(study.median('distance')),
                _millimetres(study.largest('distance')),
                _degrees(study.median('turn')),
                _degrees(study.largest('turn')),
                study.needs,
            )
        )
    return table(rows)


def _millimetres(metres: float) -> str:
    return 'never rests' if math.isinf(metres) else _number(1e3 * metres)


def _degrees(radians: float) -> str:
    return _number(math.degrees(radians))


def _number(value: float) -> str:
    """Format with three digits; rounding errors are 0."""
    return '0' if abs(value) < 1e-6 else f'{value:.3g}' if abs(value) < 1e3 else f'{value:.0f}'


def _count(number: int, thing: str) -> str:
    return f'{number} {thing}{"s" * (number != 1)}'
