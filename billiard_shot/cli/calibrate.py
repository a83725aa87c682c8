"""`billiard-shot calibrate WHAT`: fit scenes, players and machines to recordings; read films."""

import argparse
from dataclasses import dataclass
import os
from pathlib import Path
import sys
from typing import Any

import numpy as np

from billiard_shot.calibration.calibrate import calibrate, HORIZON
from billiard_shot.calibration.machine import calibrate_machine
from billiard_shot.calibration.player import errors_of, scale_of_errors
from billiard_shot.calibration.reader import read_errors, read_recording, write_csv
from billiard_shot.calibration.result import Calibration, checks_in_words
from billiard_shot.cli import output
from billiard_shot.cli.options import option, positional, Subcommand
from billiard_shot.cli.workers import OfWork, working
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.pictures.view import write_text
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import must_be
from billiard_shot.scene.fields import number
from billiard_shot.table.run.results import plural

ESTIMATES = (
    output.Column('name', 'number'),
    output.Column('value', 'value', '', '{:.4g}'.format),
    output.Column('before', 'before', '', '{:.4g}'.format),
    output.Column('unit', 'unit'),
    output.Column('low'),
    output.Column('high'),
    output.Column('shots'),
    output.Column('known', '95 % interval'),
    output.Column('doubts'),
    output.Column('converged'),
)
MOST_IGNORED = 10
"""Most reasons that are printed why shots are ignored."""


@dataclass(frozen=True)
class OfFit:
    """
    The recordings, the scene, and the fit.

    Parameters
    ----------
    recordings : RECORDING
        Files .csv or .json.
    scene : SCENE
        Where the fit begins (default: the scene that the description FILE.yaml of the first
        recording names).
    output : FILE.yaml
        Write the fitted scene.
    anyway : bool
        Write it also if the fit did not converge.
    report : FILE.html
        Write a page about it.
    fit : NAME
        Numbers to be fitted, such as cloth.sliding_friction, or cloth for all of the cloth.
    held_out : PART
        Part of the shots that check the scene, and are not fitted (default: %(default)g).
    horizon : T
        Time after the strike that counts for the fit, in s (default: %(default)g).
    seed : S
        Of the searches.

    """

    recordings: list[Path] = positional('+')
    scene: str | None = None
    output: Path | None = option('-o')
    anyway: bool = False
    report: Path | None = None
    fit: list[str] | None = None
    held_out: float = 0.25
    horizon: float = HORIZON
    seed: int = 1


def run_fit(options: argparse.Namespace) -> int:
    """Fit, print and write; ValueError for a recording or request that makes no sense."""
    with working(options.workers, options.dask) as executor, output.reporting('', 0) as report:
        result = calibrate(
            options.recordings,
            options.scene,
            names=options.fit,
            held_out=options.held_out,
            horizon=options.horizon,
            seed=options.seed,
            executor=executor,
            progress=lambda at: report(at.done, at.text, at.total),
        )
    state = {'doubts': '; '.join(result.doubts), 'converged': result.converged}
    output.print_rows(ESTIMATES, [row_of(each) | state for each in result.estimates], options)
    if output.wants_text(options):
        print(_summary(result))
    if options.output and not (result.converged or options.anyway):
        print(
            f'billiard-shot: {options.output} is not written: {result.state}; --anyway writes it',
            file=sys.stderr,
        )
    elif options.output:
        result.save(options.output)
    if options.report:
        result.report(options.report)
    return output.DONE if result.converged else output.FAILED


def row_of(estimate: Any) -> dict[str, Any]:
    """Return the row of an estimate."""
    low, high = estimate.interval or (None, None)
    return {
        'name': estimate.name,
        'value': estimate.value,
        'before': estimate.before,
        'unit': estimate.unit,
        'low': low,
        'high': high,
        'shots': ' '.join(estimate.shots),
        'known': f'{low:.4g} to {high:.4g}' if estimate.interval else 'not identifiable: kept',
    }


def _summary(result: Calibration) -> str:
    """Say how well the fit went, and how well it predicts."""
    lines = ['', f'{len(result.fitted)} shots fitted: {result.state}']
    for name, checks in (
        ('this scene', result.checks),
        ('the scene before', result.checks_before),
    ):
        if checks:
            lines.append(f'{len(checks)} shots held out, by {name}: {checks_in_words(checks)}')
    lines += result.notes
    lines += [f'ignored: {text}' for text in result.ignored[:MOST_IGNORED]]
    if len(result.ignored) > MOST_IGNORED:
        lines.append(f'ignored: {len(result.ignored) - MOST_IGNORED} more')
    return '\n'.join(lines)


table = Subcommand((OfFit(), output.OfFormat(), OfWork(os.cpu_count() or 1)), run_fit)


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


def _print_estimates(result: Any, options: argparse.Namespace) -> None:
    """Print the numbers of a player or a machine, and the sentences about them."""
    output.print_rows(COLUMNS, [row_of(each) for each in result.estimates], options)
    if output.wants_text(options):
        print('', *result.about, sep='\n')


def run_errors(options: argparse.Namespace) -> int:
    """Estimate, print and write; ValueError for a file that makes no sense."""
    scene = Scene.load(options.scene)
    if options.watched:
        result = scale_of_errors(scene, options.files)
    else:
        errors = [read_errors(path, scene.ball.radius) for path in options.files]
        result = errors_of(scene, np.concatenate(errors))
    _print_estimates(result, options)
    if options.output:
        result.save(options.output)
    return output.DONE


errors = Subcommand((OfErrors(), output.OfFormat()), run_errors)


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


def run_machine(options: argparse.Namespace) -> int:
    """Fit, print and write; ValueError if the strikes do not decide where the machine stands."""
    mechanism = Mechanism.load(options.mechanism)
    scene = Scene.load(options.scene)
    result = calibrate_machine(options.recordings, scene, mechanism.alignment)
    _print_estimates(result, options)
    if options.output:
        result.save(options.output, mechanism)
    if options.errors:
        result.save_scene(options.errors)
    return output.DONE


machine = Subcommand((OfMachine(), output.OfFormat()), run_machine)


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


def run_film(options: argparse.Namespace) -> int:
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
        with output.reporting('pictures', 0) as report:
            result = read_film(options.film, scene, corners, options.readout, report)
    except NoTableError as error:
        _, _, picture = next(Film(options.film).pictures())
        write_corner_page(picture, str(error), page)
        print(f'billiard-shot: {error}; four clicks on {page} tell its corners', file=sys.stderr)
        return output.FAILED
    write_page(result, page)
    for text in result.notes:
        print(text)
    if not options.readout:
        print('row times are taken as 0: a phone needs some 0.01 s for its rows, see --readout')
    if not result.recording.shots:
        print(f'billiard-shot: no shot was found; see {page}', file=sys.stderr)
        return output.FAILED
    write_csv(result.recording, options.output)
    write_text(about, f'scene: {options.scene}\n')
    shots = plural(len(result.recording.shots), 'shot')
    print(f'{shots} in {options.output}; the table and the tracks: {page}')
    return output.DONE


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


film = Subcommand((OfFilm(),), run_film)


@dataclass(frozen=True)
class OfConversion:
    """
    The files.

    Parameters
    ----------
    recording : FILE
        Recording (.json or .csv).
    output : FILE.csv
        File to write.

    """

    recording: Path = positional()
    output: Path = option('-o', required=True)


def run_convert(options: argparse.Namespace) -> int:
    """Write the file, and name the shots that are left out."""
    recording = read_recording(options.recording)
    write_csv(recording, options.output)
    for text in recording.ignored:
        print(f'ignored: {text}')
    print(f'{plural(len(recording.shots), "shot")} in {options.output}')
    return output.DONE


convert = Subcommand((OfConversion(),), run_convert)
