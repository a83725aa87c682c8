"""`billiard-shot calibrate errors`: the errors of a player, from measured or watched strokes."""

import argparse
from pathlib import Path

import numpy as np

from billiard_shot.calibration.player import errors_of, scale_of_errors
from billiard_shot.calibration.reader import read_errors
from billiard_shot.cli.calibrate.table import ESTIMATES, row_of
from billiard_shot.cli.output import add_format_arguments, DONE, print_rows, wants_text
from billiard_shot.scene import Scene

COLUMNS = tuple(column for column in ESTIMATES if column.key not in ('shots', 'converged'))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for strokes, scene and output."""
    parser.add_argument(
        'files',
        nargs='+',
        type=Path,
        metavar='STROKES.csv',
        help='commanded and measured strokes, with columns such as speed,measured_speed; also '
        'a, b (ball radii), elevation_deg, azimuth_deg',
    )
    parser.add_argument(
        '--watched',
        action='store_true',
        help='the files are recordings of shots whose intention is not known: estimate the scale '
        'of the errors of the scene',
    )
    parser.add_argument(
        '--scene',
        default='pool_table',
        metavar='SCENE',
        help='scene that gets these errors as its section noise (default: %(default)s)',
    )
    parser.add_argument('-o', '--output', type=Path, metavar='FILE.yaml', help='write the scene')
    add_format_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Estimate, print and write; ValueError for a file that makes no sense."""
    scene = Scene.load(options.scene)
    if options.watched:
        result = scale_of_errors(scene, options.files)
    else:
        errors = [read_errors(path, scene.ball.radius) for path in options.files]
        result = errors_of(scene, np.concatenate(errors))
    print_rows(COLUMNS, [row_of(each) for each in result.estimates], options)
    if wants_text(options):
        print('', *result.about, sep='\n')
    if options.output:
        result.save(options.output)
    return DONE
