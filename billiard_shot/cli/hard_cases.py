"""`billiard-shot hard-cases`: collisions at the limits of solvers, with checks."""

import argparse

from billiard_shot.cli.progress import progress, wait_for_machine_code
from billiard_shot.cli.text_table import table

LEGEND = """
States, steps, time: at tolerance 1e-12. off: error relative to the speed; gain: relative energy
gain; order: change with the order of contacts; sensitivity: change of the result per relative
change of the input."""
HELP = 'solve collisions at the limits of the input ranges, and check each result'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options that select cases."""
    parser.add_argument(
        'words',
        nargs='*',
        metavar='WORD',
        help='solve only cases with all these words in family and name',
    )
    parser.add_argument(
        '--list',
        action='store_true',
        help='describe each family and why it breaks other solvers; solve nothing',
    )


def run(options: argparse.Namespace) -> int:
    """Solve and print; 1 if a check fails."""
    wait_for_machine_code()
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
    from billiard_shot.study.hard_case_checks import examine, LAWS

    tasks = [(family, member, law) for family, member in chosen for law in LAWS]
    results = [examine(*task) for task in progress(tasks, 'hard cases')]
    rows = [
        (
            'case',
            'law',
            'status',
            'states',
            'steps',
            'ms',
            'off',
            'gain',
            'order',
            'sensitivity',
            'holds',
        )
    ]
    for v in results:
        rows.append(
            (
                f'{v.family}: {v.member}',
                v.law,
                v.outcome.status.name,
                str(v.outcome.states),
                str(v.outcome.steps),
                f'{1e3 * v.seconds:.1f}',
                '' if v.off != v.off else f'{v.off:.0e}',
                f'{max(v.outcome.gain, 0.0):.0e}',
                f'{v.order:.0e}',
                f'{v.sensitivity:.0e}',
                'no' if v.faults else 'yes',
            )
        )
    print(table(rows))
    print(LEGEND)
    bad = [v for v in results if v.faults]
    for v in bad:
        print(f'\n{v.family}: {v.member}, {v.law}')
        print(*(f'    {fault}' for fault in v.faults), sep='\n')
    print(f'\n{len(results) - len(bad)} of {len(results)} cases hold')
    return 1 if bad else 0
