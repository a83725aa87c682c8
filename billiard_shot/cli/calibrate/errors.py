"""`billiard-shot calibrate errors`: the errors of a player, from measured or watched strokes."""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billiard_shot.calibration.player import errors_of, scale_of_errors
from billiard_shot.calibration.reader import read_errors
from billiard_shot.cli.calibrate.table import ESTIMATES, row_of
from billiard_shot.cli.options import option, positional
from billiard_shot.cli.output import DONE, OfFormat, print_rows, wants_text
from billiard_shot.scene import Scene

OF_SHOTS = 'shots', 'doubts', 'converged'
COLUMNS = tuple(column for column in ESTIMATES if column.key not in OF_SHOTS)


@dataclass(frozen=True)
class OfErrors:
    """
    The strokes and the scene.

    Parameters
    ----------
    files : STROKES.csv
        Commanded and measured strokes, with columns such as speed,measured_speed; also a, b (ball
        radii), elevation_deg, azimuth_deg.
    watched : bool
        The files are recordings of shots whose intention is not known: estimate the scale of the
        errors of the scene.
    scene : SCENE
        Scene that gets these errors as its section noise (default: %(default)s).
    output : FILE.yaml
        Write the scene.

    """

    files: list[Path] = positional('+')
    watched: bool = False
    scene: str = 'pool_table'
    output: Path | None = option('-o')


OPTIONS = OfErrors(), OfFormat()


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
