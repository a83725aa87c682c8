"""`billiard-shot figures`: the pictures of the documentation, made anew."""

import argparse
from pathlib import Path

from billiard_shot.cli.progress import progress, wait_for_machine_code

HELP = "draw the documentation's pictures of the model and of shots anew"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Names and a folder."""
    parser.add_argument('names', nargs='*', metavar='NAME', help='which ones (all)')
    parser.add_argument(
        '--to',
        type=Path,
        default=Path('docs/figures'),
        metavar='FOLDER',
        help='where to write NAME.png (%(default)s)',
    )
    parser.add_argument('--list', action='store_true', help='name them, draw nothing')


def run(options: argparse.Namespace) -> int:
    """Draw, and say which files were written."""
    wait_for_machine_code()
    from billiard_shot.pictures.figures import FIGURES

    for name in options.names:
        if name not in FIGURES:
            raise ValueError(
                f'NAME: {name!r} is not allowed; it must be one of {", ".join(FIGURES)}'
            )
    if options.list:
        print('\n'.join(FIGURES))
        return 0
    if not options.to.is_dir():
        raise ValueError(f'--to: {options.to} is not allowed; it must be a folder')
    for name in progress(options.names or list(FIGURES), 'figures'):
        path = options.to / f'{name}.png'
        FIGURES[name](path)
        print(path)
    return 0
