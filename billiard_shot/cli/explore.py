"""`billiard-shot explore`: write a scene as an HTML page to play on."""

import argparse
from pathlib import Path

from billiard_shot.cli.shots import add_scene_argument, scene_name
from billiard_shot.pictures.view import page_of_scene, write_text

PAGE = Path('table.html')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for the scene and the page."""
    add_scene_argument(parser, 'nine_ball')
    parser.add_argument(
        '-o',
        '--output',
        type=Path,
        default=PAGE,
        metavar='FILE.html',
        help=f'output file (default: {PAGE})',
    )
    parser.add_argument('--title', help='title of the page (default: the name of the scene)')


def run(options: argparse.Namespace) -> int:
    """Write the page, and print its path."""
    if options.output.suffix != '.html':
        raise ValueError(f'--output must be a file .html, got {options.output}')
    name = scene_name(options)
    write_text(options.output, page_of_scene(name, options.title or Path(name).stem))
    print(options.output)
    return 0
