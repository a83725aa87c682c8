"""`billiard-shot study figures`: draw the figures of the documentation."""

import argparse
from pathlib import Path

from billiard_shot.cli.progress import progress
from billiard_shot.scene.errors import must_be_one_of, reason


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the names of figures and the output folder."""
    parser.add_argument('names', nargs='*', metavar='NAME', help='figures to draw (default: all)')
    parser.add_argument(
        '-o',
        '--output',
        dest='folder',
        type=Path,
        default=Path('figures'),
        metavar='FOLDER',
        help='folder for NAME.png; made if it is missing (default: %(default)s)',
    )
    parser.add_argument(
        '--list', action='store_true', help='print the names of the figures and draw nothing'
    )


def run(options: argparse.Namespace) -> int:
    """Draw the figures and print the paths of the files."""
    from billiard_shot.pictures.figures import FIGURES

    for name in options.names:
        if name not in FIGURES:
            raise ValueError(f'NAME {must_be_one_of(FIGURES, name)}')
    if options.list:
        print('\n'.join(FIGURES))
        return 0
    try:
        options.folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f'--output: {reason(error)}') from None
    for name in progress(options.names or list(FIGURES), 'figures'):
        path = options.folder / f'{name}.png'
        FIGURES[name](path)
        print(path)
    return 0
