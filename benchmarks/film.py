"""
Films of simulated shots: how well places, strikes and balls are found.

    python benchmarks/film.py [CASE ...] [--shots 1] [--write]

Each case renders a film (test/film/rendered.py) and reads it. Errors are those that remain after
the shift, turn and scale that a calibration fits as the frame of a recording.
"""

import argparse
from dataclasses import replace
from pathlib import Path
import sys
from tempfile import TemporaryDirectory
from time import process_time

from calibration import RANGES
import cv2
import numpy as np
from tools.timing import Report

from billiard_shot import calibrate, Scene
from billiard_shot.calibration.recording import Track
from billiard_shot.film.film import read_film
from billiard_shot.film.page import drawn
from billiard_shot.film.table_in_picture import NoTableError

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'test' / 'film'))
from rendered import filmed, Filming, OBLIQUE, OVERHEAD

LONGEST, EXCHANGED = 2.0, 0.03  # s, m
FAR_OBLIQUE = replace(OBLIQUE, place=(-0.3, -2.7, 2.2))
ASIDE = replace(OBLIQUE, place=(3.4, -1.0, 2.6), at=(0.3, -0.02, 0.0), up=(-1.0, 0.3, 0.0))
CASES = {
    'overhead': Filming(),
    'overhead-30': Filming(rate=30.0),
    'overhead-240': Filming(rate=240.0),
    'slow-shutter': Filming(exposure=1 / 60),
    'oblique': Filming(view=FAR_OBLIQUE),
    'oblique-green': Filming(view=FAR_OBLIQUE, cloth='green'),
    'aside': Filming(view=ASIDE),
    'hand-held': Filming(shake=0.5),
    'robot': Filming(cloth='pool'),
    'break': Filming(cloth='pool'),
}
SCENES = {'robot': 'robot_table', 'break': 'eight_ball'}  # else carom
SPEEDS = {'break': (5.0, 7.0)}  # m/s
DRAWN = 'overhead', 'oblique-green', 'aside'
TEN_SHOTS, TABLE, HORIZON, RULER = 'ten-shots', 1, 3.0, 0.002  # s, m
PICTURES = {}  # files by cases, if pictures are wanted


def measure(report, name, filming, shots, folder):
    """Film, read and compare; state what was found."""
    scene = Scene.load(SCENES.get(name, 'carom'))
    path = folder / f'{name}.mp4'
    speed = SPEEDS.get(name, (1.5, 3.5))
    motion = filmed(path, scene, filming, shots, 7, longest=LONGEST, speed=speed)
    begin, oblique = process_time(), filming.view is not OVERHEAD
    try:
        result = read_film(path, scene, readout=filming.readout)
    except NoTableError as error:
        print(f'{name}: {error}')
        report.row(f'{name}: tables found', 0, '', -1)
        return
    seconds = process_time() - begin
    truth, seen, sigma, expected = [], [], [], 0
    for shot, recorded in zip(result.shots, result.recording.shots, strict=True):
        expected += round((shot.end - shot.begin) * filming.rate) * len(motion.places)
        for ball, track in recorded.tracks.items():
            at = motion.at(ball, track.time + shot.strike + 0.5 * filming.exposure)
            truth.append(at[:, :2] @ [1, 1j])
            seen.append(track.place @ [1, 1j])
            sigma.append(track.sigma)
    truth, seen, sigma = (np.concatenate(each) for each in (truth, seen, sigma))
    right = np.abs(seen - truth) < EXCHANGED
    a, b = truth[right] - truth[right].mean(), seen[right] - seen[right].mean()
    off = b / ((b * a.conj()).sum() / (np.abs(a) ** 2).sum()) - a
    allowed = 2.0 if oblique else 1.0
    report.row(f'{name}: tables found', 1, '', -1)
    report.row(f'{name}: error, median', 1e3 * np.median(np.abs(off)), 'mm', 0.5 * allowed)
    report.row(f'{name}: error, 95 %', 1e3 * np.quantile(np.abs(off), 0.95), 'mm', 1.5 * allowed)
    report.row(f'{name}: sights', len(truth), '')
    report.row(f'{name}: lost', 1.0 - len(truth) / max(expected, 1), '', 0.01)
    told = sum('exchanged' in note for note in result.notes)
    most = None if told else 0.5  # a limit of 0 would be a lower one
    report.row(f'{name}: sights of an exchanged ball', int((~right).sum()), '', most)
    report.row(f'{name}: pairs that may be exchanged, as the notes say', told, '')
    both = np.abs(np.concatenate([off.real, off.imag]))
    covered = np.mean(both < 1.645 * np.concatenate([sigma[right], sigma[right]]))
    report.row(f'{name}: within the 90 % of the stated deviation', covered, '', -0.9)
    strikes = np.array([shot.strike for shot in result.shots]) + 0.5 * filming.exposure
    report.row(f'{name}: shots', len(strikes), '', -len(motion.starts))
    if len(strikes) == len(motion.starts):
        late = np.abs(strikes - motion.starts).max()
        report.row(f'{name}: strike', late * filming.rate, 'pictures', 0.25)
    pictures = round(motion.end * filming.rate)
    report.row(f'{name}: CPU time of a picture', 1e3 * seconds / pictures, 'ms')
    for note in result.notes:
        print(f'    {note}')
    if name in PICTURES:
        picture, _ = drawn(result, result.shots[0])
        code = cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)
        cv2.imwrite(str(PICTURES[name]), code, [cv2.IMWRITE_JPEG_QUALITY, 85])


def measure_calibration(report, folder):
    """Calibrate ten filmed shots, and the same shots from exact places with errors of 1 mm."""
    draw, start = np.random.default_rng(TABLE), Scene.load('carom')
    truth = {name: float(draw.uniform(*bounds)) for name, bounds in RANGES.items()}
    there, path = start.with_parameters(list(truth), list(truth.values())), folder / 'ten.mp4'
    filming = Filming(replace(OVERHEAD, size=(640, 360), focal=546.5), rate=30.0)
    motion = filmed(path, there, filming, 10, 7, longest=HORIZON + 0.2)
    ruler = [truth['table.length'] + RULER, truth['table.width'] - RULER]
    stated = start.with_parameters(['table.length', 'table.width'], ruler)
    result = read_film(path, stated, readout=filming.readout)
    exact = []
    for shot, seen in zip(result.shots, result.recording.shots, strict=True):
        tracks = {}
        for ball, track in seen.tracks.items():
            at = motion.at(ball, track.time + shot.strike + 0.5 * filming.exposure)[:, :2]
            places = at + draw.normal(0.0, 1e-3, at.shape)
            tracks[ball] = Track(track.time, places, np.full(len(at), 1e-3))
        exact.append(replace(seen, tracks=tracks))
    recordings = result.recording, replace(result.recording, shots=tuple(exact))
    found, reference = (
        calibrate(
            each, replace(stated, balls={}), names=list(truth), horizon=HORIZON, held_out=0.0
        )
        for each in recordings
    )
    report.row('ten shots: shots', len(result.shots), '', -10)
    held, ratios = [], []
    known = {each.name: each.interval for each in reference.estimates if each.interval}
    for each in found.estimates:
        if each.interval and each.name in truth:
            low, high = each.interval
            held.append(low <= truth[each.name] <= high)
            print(f'    {each.name}: {truth[each.name]:.5g} in {low:.5g} to {high:.5g}', end='')
            if each.name in known:
                ratios.append((high - low) / np.ptp(known[each.name]))
                print(f', {ratios[-1]:.2f} times as wide', end='')
            print()
    for name, each in ('film', found), ('exact places', reference):
        print(f'    {name}: {each.state}')
    report.row('ten shots: intervals', len(held), '')
    report.row('ten shots: intervals that hold', np.mean(held), '', -0.95)
    report.row('ten shots: width relative to exact places, median', np.median(ratios), '', 1.5)


def main():
    """Measure the cases."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument(
        'cases',
        nargs='*',
        metavar='CASE',
        help=f'{", ".join(CASES)}, {TEN_SHOTS} (default: {", ".join(DRAWN)})',
    )
    parser.add_argument('--shots', type=int, default=1)
    parser.add_argument('--write', action='store_true', help='draw the pictures of docs/film.md')
    options = parser.parse_args()
    if options.write:
        folder = Path(__file__).resolve().parent.parent / 'docs' / 'figures'
        PICTURES.update({name: folder / f'film-{name}.jpg' for name in DRAWN})
    report = Report('films of simulated shots')
    with TemporaryDirectory() as folder:
        for name in options.cases or DRAWN:
            if name == TEN_SHOTS:
                measure_calibration(report, Path(folder))
                continue
            measure(report, name, CASES[name], options.shots, Path(folder))
    report.end()


if __name__ == '__main__':
    main()
