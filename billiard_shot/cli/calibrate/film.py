"""`billiard-shot calibrate film`: a recording from a film of a table."""

import argparse
from dataclasses import dataclass
from pathlib import Path
import sys
from typing import Any

import numpy as np

from billiard_shot.calibration.reader import write_csv
from billiard_shot.cli.options import option, positional
from billiard_shot.cli.output import DONE, FAILED, reporting
from billiard_shot.pictures.view import write_text
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import must_be
from billiard_shot.scene.fields import number
from billiard_shot.table.run.outline import outline_of


@dataclass(frozen=True)
class OfFilm:
    """
    The film, the scene, and the files to write.

    Parameters
    ----------
    film : FILM
        A film, such as shots.mp4.
    scene : SCENE
        Its table with stated length and width, and its balls (default: %(default)s).
    output : FILE.csv
        Recording to write; beside it, FILE.yaml describes it, and FILE.html shows the film with
        what was found.
    corners : U,V
        Pixels of the four corners of the noses, told by four clicks on the page (default: they are
        found).
    readout : T
        Time that the camera takes to read all rows of a picture, in s (default: %(default)g).

    """

    film: Path = positional()
    scene: str = 'carom'
    output: Path = option('-o', required=True)
    corners: tuple[str, str, str, str] | None = option(metavar='U,V')
    readout: float = number('s', minimum=0.0, maximum=0.1, default=0.0)


OPTIONS = (OfFilm(),)


def run(options: argparse.Namespace) -> int:
    """Track the balls and write the files; ValueError for a film that cannot be used."""
    corners = _corners_of(options.corners)
    scene = Scene.load(options.scene)
    if scene.table is None or len(scene.balls) < 1:
        raise ValueError(f'--scene {must_be("a scene with a table and balls", options.scene)}')
    page = options.output.with_suffix('.html')
    about = options.output.with_suffix('.yaml')
    try:
        from billiard_shot.film.film import read_film
        from billiard_shot.film.page import write_corner_page, write_page
        from billiard_shot.film.reading import Film
        from billiard_shot.film.table_in_picture import NoTableError
    except ImportError as error:
        raise ValueError(
            f"films need OpenCV and PyAV: pip install 'billiard_shot[film]' ({error})"
        ) from None
    try:
        with reporting('pictures', 0) as report:
            result = read_film(options.film, scene, corners, options.readout, report)
    except NoTableError as error:
        _, _, picture = next(Film(options.film).pictures())
        write_corner_page(picture, str(error), page)
        print(f'billiard-shot: {error}; four clicks on {page} tell its corners', file=sys.stderr)
        return FAILED
    write_page(result, scene.ball.radius, outline_of(scene).height, page)
    for text in result.notes:
        print(text)
    if not options.readout:
        print('row times are taken as 0: a phone needs some 0.01 s for its rows, see --readout')
    if not result.recording.shots:
        print(f'billiard-shot: no shot was found; see {page}', file=sys.stderr)
        return FAILED
    write_csv(result.recording, options.output)
    write_text(about, f'scene: {options.scene}\n')
    print(f'{len(result.recording.shots)} shots in {options.output}; what was found: {page}')
    return DONE


def _corners_of(words: tuple[str, ...] | None) -> Any:
    """Return corners (4, 2) [px] from words such as 12.5,80."""
    if words is None:
        return None
    try:
        corners = np.array([[float(part) for part in word.split(',')] for word in words])
    except ValueError:
        corners = np.empty(0)
    if corners.shape != (4, 2) or not np.isfinite(corners).all():
        raise ValueError(f'--corners {must_be("four pixels, each such as 12.5,80", words)}')
    return corners
