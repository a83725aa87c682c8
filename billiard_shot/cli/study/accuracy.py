"""`billiard-shot study accuracy`: error and cost of tolerances in a scene, to choose one."""

import argparse
from dataclasses import asdict, dataclass
from pathlib import Path

from billiard_shot import Scene
from billiard_shot.cli.output import (
    Column,
    OfFormat,
    print_footer,
    print_rows,
    progress,
    wants_text,
)
from billiard_shot.cli.shots import OfUsualScene, scene_name
from billiard_shot.pictures.study import draw_accuracy
from billiard_shot.scene.fields import whole_number
from billiard_shot.study import cost_of_accuracy, SHOT_TOLERANCES, study_accuracy


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
    Column('tolerance', 'tolerance', '', length),
    Column('typical_error', 'typical', 'error', length),
    Column('largest_error', 'largest', 'error', length),
    Column('strike', 'strike', '', duration),
    Column('alone', 'shot', 'alone', duration),
    Column('shot', 'shot', 'all balls', duration),
)


@dataclass(frozen=True)
class OfStudy:
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


OPTIONS = OfUsualScene('eight_ball'), OfStudy(), OfFormat()


def run(options: argparse.Namespace) -> int:
    """Measure, print, draw."""
    name = scene_name(options)
    scene = Scene.load(name)
    studied = list(
        progress(study_accuracy(scene, count=options.count), 'accuracy', len(SHOT_TOLERANCES))
    )
    if wants_text(options):
        print(f'scene {name}, {options.count} random strokes')
    print_rows(TOLERANCE_COLUMNS, [asdict(each) for each in studied], options)
    print_footer(
        f'Result: {cost_of_accuracy(studied)}. Errors are those of the place of rest of the cue '
        'ball without the other balls. Processor times are those of a strike on endless cloth, of '
        'a shot without the other balls, and of a shot with all balls.',
        options,
    )
    if options.picture:
        draw_accuracy(studied, options.picture, f'scene {name}')
    return 0
