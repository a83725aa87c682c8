"""`billiard-shot calibrate errors`: the errors of a player, from measured strokes."""

import argparse
from pathlib import Path

from billiard_shot.calibration.errors import errors_of
from billiard_shot.calibration.strokes_csv import read_errors
from billiard_shot.cli.calibrate.table import ESTIMATES, row_of
from billiard_shot.cli.exit_codes import DONE
from billiard_shot.cli.text_table import add_format_arguments, print_rows, wants_text
from billiard_shot.scene import Scene

COLUMNS = tuple(column for column in ESTIMATES if column.key != 'shots')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for strokes, scene and output."""
    parser.add_argument(
        'strokes',
        type=Path,
        metavar='STROKES.csv',
        help='commanded and measured strokes, with columns such as speed,measured_speed; also '
        'a, b (ball radii), elevation_deg, azimuth_deg',
    )
    parser.add_argument(
        '--scene',
        default='pool',
        metavar='SCENE',
        help='scene that gets these errors as its section noise (default: %(default)s)',
    )
    parser.add_argument('-o', '--output', type=Path, metavar='FILE.yaml', help='write the scene')
    add_format_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Estimate, print and write; ValueError for a file that makes no sense."""
    scene = Scene.load(options.scene)
    result = errors_of(scene, read_errors(options.strokes, scene.ball.radius))
    print_rows(COLUMNS, [row_of(each) for each in result.estimates], options)
    if wants_text(options):
        print('', *result.about, sep='\n')
    if options.output:
        result.save(options.output)
    return DONE
