"""`billiard-shot view`: a shot as an HTML page with a table to turn and zoom."""

import argparse
from pathlib import Path
import sys

from billiard_shot.cli.shots import add_shot_arguments, of_each, shots_of
from billiard_shot.pictures.view import write_page

HELP = 'write a shot as one HTML file: the table in 3-D, balls that turn, a time slider'


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Shots, and where to write."""
    parser.add_argument(
        '--to',
        type=Path,
        default=Path('shot.html'),
        metavar='FILE.html',
        help='where to write; of several strokes, FILE-NAME (%(default)s)',
    )
    parser.add_argument('--title', help='of the page; the name of the shot by default')
    add_shot_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Write the pages, and say where they are; 1 if a stroke was refused."""
    shots = shots_of(options)
    for name, shot in shots.items():
        path = of_each(options.to, name, shots)
        write_page(shot, path, options.title or _title(name, options))
        print(path)
        if shot.status.refused:
            print(f'stroke {name}: {shot.status.name}: {shot.message}', file=sys.stderr)
    return 1 if any(shot.status.refused for shot in shots.values()) else 0


def _title(name: str, options: argparse.Namespace) -> str:
    """Name of the shot if it has one, else of the scene."""
    return name if options.shot or options.strokes else options.scene or 'pool'
