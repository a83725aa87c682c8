"""
Films of simulated shots: how well places, strikes and balls are found.

    python benchmarks/film.py [CASE ...] [--shots 2] [--write]

Each case renders a film (test/film/rendered.py) and reads it. Errors are those that remain after
the shift, turn and scale that a calibration fits as the frame of a recording.
"""

import argparse
from dataclasses import replace
from pathlib import Path
import sys
from tempfile import TemporaryDirectory
from time import process_time

import cv2
import numpy as np
from tools.timing import Report

from billiard_shot import Scene
from billiard_shot.film.film import read_film
from billiard_shot.film.table_in_picture import NoTableError
from billiard_shot.film.tracks import rows_of
from billiard_shot.scene.placement import Rack, racked
from billiard_shot.table.run.outline import outline_of

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'test' / 'film'))
from rendered import filmed, Filming, OBLIQUE, OVERHEAD

LONGEST, EXCHANGED = 2.0, 0.03  # s, m
FAR_OBLIQUE = replace(OBLIQUE, place=(-0.3, -2.7, 2.2))
ASIDE = replace(OBLIQUE, place=(2.6, -1.2, 2.3), at=(0.1, 0.0, 0.0), up=(-1.0, 0.4, 0.0))
CASES = {
    'overhead': Filming(),
    'overhead-30': Filming(rate=30.0),
    'overhead-240': Filming(rate=240.0),
    'slow-shutter': Filming(exposure=1 / 60),
    'oblique': Filming(view=FAR_OBLIQUE),
    'oblique-green': Filming(view=FAR_OBLIQUE, cloth='green'),
    'aside': Filming(view=ASIDE),
    'hand-held': Filming(shake=0.5),
    'break': Filming(cloth='green'),
}
DRAWN = 'overhead', 'oblique-green', 'aside'
PICTURES = {}  # files by cases, if pictures are wanted


def broken() -> Scene:
    """A rack of eight-ball."""
    scene = Scene.load('pool_table')
    rack = racked(Rack('eight_ball'), scene.table, scene.ball.radius)
    return replace(scene, balls={'cue': (-0.635, 0.02), **rack})


def measure(report, name, filming, shots, folder):
    """Film, read and compare; state what was found."""
    is_break = name == 'break'
    scene = broken() if is_break else Scene.load('carom')
    how = {'speed': (4.0, 5.0)} if is_break else {}
    path = folder / f'{name}.mp4'
    motion = filmed(path, scene, filming, 1 if is_break else shots, 7, longest=LONGEST, **how)
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
    report.row(f'{name}: sights of an exchanged ball', int((~right).sum()), '', 0)
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
        draw(result, scene, PICTURES[name], name != 'overhead')


def draw(result, scene, path, tracks):
    """Draw noses, sights, balls and, if wanted, tracks of the first shot into a picture."""
    camera, shot, radius = result.table.camera, result.shots[0], scene.ball.radius
    time, picture = min(result.pictures, key=lambda each: abs(each[0] - shot.strike - 0.4))
    picture = cv2.cvtColor(picture, cv2.COLOR_RGB2BGR)

    def line(points, colour, closed):
        fine = np.round(8.0 * camera.project(points)).astype(np.int32)
        cv2.polylines(picture, [fine], closed, colour, 2, cv2.LINE_AA, 3)

    signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    corners = np.linspace(signs, np.roll(signs, -1, axis=0), 30, axis=1).reshape(-1, 2)
    height = np.full((len(corners), 1), outline_of(scene).height)
    line(np.hstack([corners * camera.half, height]), (66, 228, 240), True)
    for u, v in np.round(8.0 * result.table.sights.pixel).astype(int).tolist():
        cv2.circle(picture, (u, v), 48, (167, 121, 204), 2, cv2.LINE_AA, 3)
    for path_of_ball in result.balls.values():
        rows = rows_of(path_of_ball)
        rows = rows[(rows[:, 0] > shot.begin) & (rows[:, 0] < shot.end)]
        lifted = np.column_stack([rows[:, 1:3], np.full(len(rows), radius)])
        if tracks:
            line(lifted, (0, 0, 0), False)
        place = lifted[np.abs(rows[:, 0] - time).argmin()][np.newaxis]
        ring = np.round(8.0 * camera.outlines(place, radius, 40)).astype(np.int32)
        cv2.polylines(picture, [ring[0]], True, (255, 255, 255), 2, cv2.LINE_AA, 3)
    cv2.imwrite(str(path), picture, [cv2.IMWRITE_JPEG_QUALITY, 85])


def main():
    """Measure the cases."""
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[1])
    parser.add_argument('cases', nargs='*', metavar='CASE', help=', '.join(CASES))
    parser.add_argument('--shots', type=int, default=2)
    parser.add_argument('--write', action='store_true', help='draw the pictures of docs/film.md')
    options = parser.parse_args()
    if options.write:
        folder = Path(__file__).resolve().parent.parent / 'docs' / 'figures'
        PICTURES.update({name: folder / f'film-{name}.jpg' for name in DRAWN})
    report = Report('films of simulated shots')
    with TemporaryDirectory() as folder:
        for name in options.cases or CASES:
            measure(report, name, CASES[name], options.shots, Path(folder))
    report.end()


if __name__ == '__main__':
    main()
