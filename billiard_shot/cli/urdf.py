"""`billiard-shot urdf`: the mechanical cue as a robot model."""

import argparse
from pathlib import Path

from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.model import urdf_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for mechanism, frame and output."""
    parser.add_argument(
        '--mechanism',
        default='',
        metavar='FILE',
        help='YAML file of the mechanism (default: the built-in one)',
    )
    parser.add_argument(
        '--frame',
        default='table',
        help="name of the table's frame, such as cell1/table (default: %(default)s)",
    )
    parser.add_argument(
        '-o', '--output', type=Path, metavar='FILE', help='output file (default: standard output)'
    )


def run(options: argparse.Namespace) -> int:
    """Print or write the model."""
    if not options.frame:
        raise ValueError("--frame must be a name, got ''")
    text = urdf_of(Mechanism.load(options.mechanism), options.frame)
    if options.output:
        options.output.write_text(text, encoding='utf-8')
    else:
        print(text, end='')
    return 0
