"""`billiard-shot study tolerance`: error and cost of tolerances, to choose one."""

import argparse
from dataclasses import asdict
from pathlib import Path

from billiard_shot.cli.progress import progress
from billiard_shot.cli.text_table import (
    add_format_arguments,
    Column,
    print_footer,
    print_rows,
)
from billiard_shot.study.tolerances import cost_of_accuracy, SHOT_TOLERANCES, study_tolerances


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
    Column('shot', 'shot', '', duration),
    Column('opening', 'break', '', duration),
    Column('plan', 'plan', '', duration),
    Column('success', 'success', 'of plan', '{:.1%}'.format),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for the picture and the format."""
    parser.add_argument('--picture', type=Path, metavar='FILE.png', help='draw errors and times')
    parser.add_argument(
        '--count',
        type=int,
        default=100,
        metavar='N',
        help='random shots for each tolerance (default: %(default)d)',
    )
    add_format_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Measure, print, draw."""
    if options.count < 1:
        raise ValueError(f'--count must be at least 1, got {options.count}')
    study = study_tolerances(shots=options.count, judged=10 * options.count)
    studied = list(progress(study, 'tolerance', len(SHOT_TOLERANCES)))
    print_rows(TOLERANCE_COLUMNS, [asdict(each) for each in studied], options)
    print_footer(
        f'Result: {cost_of_accuracy(studied)}. '
        'Errors are those of the place of rest, on a table without other balls. Processor times '
        'are those of a strike on an infinite cloth, of a shot on that table, of a break at '
        f'eight-ball, and of {10 * options.count} trials of a plan. Success is the fraction of '
        'these trials that reach the target.',
        options,
    )
    if options.picture:
        from billiard_shot.pictures.tolerances import draw_tolerances

        draw_tolerances(studied, options.picture)
    return 0
