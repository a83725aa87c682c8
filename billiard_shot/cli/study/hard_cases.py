"""`billiard-shot study hard-cases`: collisions at the limits of solvers, with checks."""

import argparse
import math
from typing import Any

from billiard_shot.cli.progress import progress
from billiard_shot.cli.text_table import add_format_arguments, Column, print_rows, wants_text
from billiard_shot.cli.workers import add_work_arguments, mapped

LEGEND = """
Steps: at tolerance 1e-12. off: error relative to the speed; gain: relative
energy gain; order: change with the order of contacts; sens (sensitivity):
change of the result per relative change of the input. States and times: --csv
or --json."""


def _power(value: float) -> str:
    return '' if math.isnan(value) else f'{value:.0e}'


CASE_COLUMNS = (
    Column('case'),
    Column('law', 'case, law'),
    Column('steps', 'steps'),
    Column('off', 'off', '', _power),
    Column('gain', 'gain', '', _power),
    Column('order', 'order', '', _power),
    Column('sensitivity', 'sens', '', _power),
    Column('holds', 'holds', '', lambda holds: 'yes' if holds else 'no'),
    Column('status', 'status'),
    Column('states'),
    Column('seconds'),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options that select cases."""
    parser.add_argument(
        'words',
        nargs='*',
        metavar='WORD',
        help='solve only cases with all these words in family and name',
    )
    add_format_arguments(parser)
    add_work_arguments(parser)
    parser.add_argument(
        '--list',
        action='store_true',
        help='describe each family and why it breaks other solvers; solve nothing',
    )


def run(options: argparse.Namespace) -> int:
    """Solve and print; 1 if a check fails."""
    from billiard_shot.study.hard_cases import families

    chosen = [
        (family, member)
        for family in families()
        for member in family.members
        if all(word in f'{family.name}: {member}' for word in options.words)
    ]
    if not chosen:
        raise ValueError(f'WORD: {" ".join(options.words)!r} is not part of any case; see --list')
    if options.list:
        for family in dict.fromkeys(family.name for family, _ in chosen):
            about = next(entry for entry, _ in chosen if entry.name == family)
            print(f'{family}: {about.breaks}')
            print(*(f'    {member}' for entry, member in chosen if entry.name == family), sep='\n')
        return 0
    from billiard_shot.study.hard_case_checks import CHECKED_LAWS

    tasks = [(family, member, law) for family, member in chosen for law in CHECKED_LAWS]
    results = list(progress(mapped(options, _examine, tasks), 'hard cases', len(tasks)))
    print_rows(CASE_COLUMNS, [_row(result) for result in results], options, 'case')
    bad = [v for v in results if v.faults]
    if not wants_text(options):
        return 1 if bad else 0
    print(LEGEND)
    for v in bad:
        print(f'\n{v.family}: {v.member}, {v.law}')
        print(*(f'    {fault}' for fault in v.faults), sep='\n')
    print(f'\n{len(results) - len(bad)} of {len(results)} cases hold')
    return 1 if bad else 0


def _examine(task: tuple[Any, str, str]) -> Any:
    from billiard_shot.study.hard_case_checks import examine

    return examine(*task)


def _row(v: Any) -> dict[str, Any]:
    return {
        'case': f'{v.family}: {v.member}',
        'law': v.law,
        'steps': v.outcome.steps,
        'off': v.off,
        'gain': max(v.outcome.gain, 0.0),
        'order': v.order,
        'sensitivity': v.sensitivity,
        'holds': not v.faults,
        'status': v.outcome.status.name,
        'states': v.outcome.states,
        'seconds': v.seconds,
    }
