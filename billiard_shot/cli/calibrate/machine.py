"""`billiard-shot calibrate machine`: where a machine stands at its table, and how it errs."""

import argparse
from pathlib import Path

from billiard_shot.calibration.machine import calibrate_machine
from billiard_shot.cli.calibrate.errors import COLUMNS
from billiard_shot.cli.calibrate.table import row_of
from billiard_shot.cli.output import add_format_arguments, DONE, print_rows, wants_text
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.scene import Scene


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add options for recordings, scene, mechanism and output."""
    parser.add_argument(
        'recordings',
        nargs='+',
        type=Path,
        metavar='RECORDING',
        help='files .csv of the node shot_recorder, with at least ten strikes: at several places, '
        'in several directions, at several speeds and elevations',
    )
    parser.add_argument(
        '--scene', required=True, metavar='SCENE', help='the table, with a guided cue'
    )
    parser.add_argument(
        '--mechanism',
        default='',
        metavar='FILE.yaml',
        help='the mechanism of the driver that recorded, with its alignment (default: that of a '
        'driver without the parameter mechanism)',
    )
    parser.add_argument(
        '-o',
        '--output',
        type=Path,
        metavar='FILE.yaml',
        help='write the mechanism with its alignment, for the parameter mechanism of the driver',
    )
    parser.add_argument(
        '--errors',
        type=Path,
        metavar='FILE.yaml',
        help="write the scene with the robot's errors as its section noise",
    )
    add_format_arguments(parser)


def run(options: argparse.Namespace) -> int:
    """Fit, print and write; ValueError if the strikes do not decide where the machine stands."""
    mechanism = Mechanism.load(options.mechanism)
    scene = Scene.load(options.scene)
    result = calibrate_machine(options.recordings, scene, mechanism.alignment)
    print_rows(COLUMNS, [row_of(each) for each in result.estimates], options)
    if wants_text(options):
        print('', *result.about, sep='\n')
    if options.output:
        result.save(options.output, mechanism)
    if options.errors:
        result.save_scene(options.errors)
    return DONE
