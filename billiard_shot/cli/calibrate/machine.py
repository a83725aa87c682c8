"""`billiard-shot calibrate machine`: where a machine stands at its table, and how it errs."""

import argparse
from dataclasses import dataclass
from pathlib import Path

from billiard_shot.calibration.machine import calibrate_machine
from billiard_shot.cli.calibrate.errors import COLUMNS
from billiard_shot.cli.calibrate.table import row_of
from billiard_shot.cli.options import option, positional
from billiard_shot.cli.output import DONE, OfFormat, print_rows, wants_text
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.scene import Scene


@dataclass(frozen=True)
class OfMachine:
    """
    The recordings, the scene and the mechanism.

    Parameters
    ----------
    recordings : RECORDING
        Files .csv of the node shot_recorder, with at least ten strikes: at several places, in
        several directions, at several speeds and elevations.
    scene : SCENE
        The table, with a guided cue.
    mechanism : FILE.yaml
        The mechanism of the driver that recorded, with its alignment (default: that of a driver
        without the parameter mechanism).
    output : FILE.yaml
        Write the mechanism with its alignment, for the parameter mechanism of the driver.
    errors : FILE.yaml
        Write the scene with the robot's errors as its section noise.

    """

    recordings: list[Path] = positional('+')
    scene: str = option(required=True)
    mechanism: str = ''
    output: Path | None = option('-o')
    errors: Path | None = None


OPTIONS = OfMachine(), OfFormat()


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
