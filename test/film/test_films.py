"""Films whose truth is known: what is found, and what is said of films that cannot be used."""

from dataclasses import replace
import sys

import av
import cv2
import numpy as np
import pytest
import rendered
from rendered import (
    filmed,
    Filming,
    LAMPS,
    Motion,
    OBLIQUE,
    OVERHEAD,
    Painter,
    Placed,
    View,
    write_film,
)

from billiard_shot import Scene
from billiard_shot.calibration.reader import read_recording
from billiard_shot.calibration.recording import tracking_of
from billiard_shot.cli import main
from billiard_shot.cli.output import DONE, FAILED, WRONG_INPUT
from billiard_shot.film.balls import BallFinder
from billiard_shot.film.cloth import fit_cloth
from billiard_shot.film.film import read_film, UPSIDE_DOWN
from billiard_shot.film.reading import Film, FilmError, Steady
from billiard_shot.film.table_in_picture import cloth_corners, find_table, NoTableError
from billiard_shot.film.watched_table import WatchedTable

READOUT, POTTING = 0.012, 1
SMALL = replace(OVERHEAD, size=(640, 360), focal=546.5)
SMALL_OBLIQUE = replace(OBLIQUE, place=(-0.3, -2.7, 2.2), size=(640, 360), focal=575.0)

BEHIND = View((-3.0, 0.05, 2.1), (0.0, 0.0, 0.0), (640, 360), 560.0, up=(1.0, 0.0, 0.0))


def errors_of(result, motion, filming):
    """Errors of x and y [m] of all sights of shots, less shift, turn and scale; and deviations."""
    truth, seen, sigma = [], [], []
    for shot, recorded in zip(result.shots, result.recording.shots, strict=True):
        for name, track in recorded.tracks.items():
            at = motion.at(name, track.time + shot.strike + 0.5 * filming.exposure)
            truth.append(at[:, :2] @ [1, 1j])
            seen.append(track.place @ [1, 1j])
            sigma.append(track.sigma)
    truth, seen = (np.concatenate(each) for each in (truth, seen))
    truth, seen = truth - truth.mean(), seen - seen.mean()
    off = seen / ((seen * truth.conj()).sum() / (np.abs(truth) ** 2).sum()) - truth
    return off, np.concatenate(sigma)


@pytest.fixture(scope='module')
def overhead(tmp_path_factory):
    """Two shots, 30 pictures a second."""
    path = tmp_path_factory.mktemp('film') / 'shots.mp4'
    filming = Filming(view=SMALL, rate=30.0)
    return path, filming, filmed(path, 'carom', filming, shots=2, longest=1.5)


@pytest.fixture(scope='module')
def found(overhead):
    path, filming, motion = overhead
    return read_film(path, Scene.load('carom'), readout=filming.readout), motion, filming


def test_places_are_found(found):
    off, sigma = errors_of(*found)
    assert np.median(np.abs(off)) < 0.5e-3
    assert np.quantile(np.abs(off), 0.95) < 1.5e-3
    both = np.abs(np.concatenate([off.real, off.imag]))
    assert np.mean(both < 1.645 * np.concatenate([sigma, sigma])) > 0.8


def test_no_ball_is_lost_or_exchanged(found):
    result, _, filming = found
    assert len(result.shots) == 2
    for shot, recorded in zip(result.shots, result.recording.shots, strict=True):
        pictures = (shot.end - shot.begin) * filming.rate
        for track in recorded.tracks.values():
            assert len(track.time) > 0.98 * pictures
    assert np.abs(errors_of(*found)[0]).max() < 0.01


def test_strikes_are_found_between_pictures(found):
    result, motion, filming = found
    strikes = [shot.strike + 0.5 * filming.exposure for shot in result.shots]
    assert np.abs(np.subtract(strikes, motion.starts)).max() < 0.25 / filming.rate
    assert [shot.struck for shot in result.shots] == ['cue', 'cue']


def test_row_times_matter(overhead, found):
    path, filming, motion = overhead
    without = read_film(path, Scene.load('carom'))
    fine, coarse = (np.abs(errors_of(each, motion, filming)[0]) for each in (found[0], without))
    assert np.quantile(coarse, 0.95) > 2.0 * np.quantile(fine, 0.95)


def test_an_oblique_view(tmp_path):
    path = tmp_path / 'oblique.mp4'
    filming = Filming(view=SMALL_OBLIQUE, rate=30.0)
    motion = filmed(path, 'carom', filming, shots=1, seed=4, longest=1.5)
    result = read_film(path, Scene.load('carom'), readout=filming.readout)
    off, _ = errors_of(result, motion, filming)
    assert np.median(np.abs(off)) < 1e-3
    # a pixel is 5.6 mm, and colours have half the resolution: the red ball is the least sure
    assert np.quantile(np.abs(off), 0.95) < 4.5e-3


def test_the_command_writes_what_a_calibration_reads(overhead, tmp_path, capsys):
    path, _, _ = overhead
    written = tmp_path / 'shots.csv'
    words = ['calibrate', 'film', str(path), '--scene', 'carom', '-o', str(written)]
    assert main([*words, '--readout', str(READOUT)]) == DONE
    assert '2 shots in' in capsys.readouterr().out
    recording = read_recording(written)
    assert (recording.scene, len(recording.shots)) == ('carom', 2)
    assert set(recording.shots[0].tracks) == {'cue', 'yellow', 'red'}
    tracking_of(recording)  # the stated deviations are not contradicted
    page = (tmp_path / 'shots.html').read_text()
    assert page.count('<img') == 1 + 2
    assert '--corners' in page


def still(scene='carom', view=SMALL, time=0.1, **how):
    """A picture in which all balls rest."""
    scene = Scene.load(scene)
    scene = replace(scene, balls={'8': (0.6, 0.1), **scene.balls})
    painter = Painter(scene, Motion(scene, 1, longest=0.1), Filming(view=view, hand=False, **how))
    return painter.at(time)


def test_a_table_with_pockets_is_found():
    table = find_table(still('pool_table', cloth='green'), Scene.load('pool_table'))
    assert len(table.sights.at) == 18
    np.testing.assert_allclose(table.camera.place[:2], SMALL.place[:2], atol=0.05)


def people_at_rails(picture):
    """Two who stand behind the far rail, and one who leans over the foot rail."""
    for body, colour in (
        ([(120, 0), (238, 0), (238, 27), (180, 31), (120, 4)], (60, 50, 48)),
        ([(426, 0), (510, 0), (508, 8), (480, 16), (427, 13)], (150, 40, 50)),
        ([(640, 178), (565, 181), (563, 226), (640, 243)], (225, 225, 220)),
    ):
        cv2.fillPoly(picture, [np.array(body)], colour, cv2.LINE_AA)
    return picture


def scoreboard(picture):
    """A strip over the bed, along the near rail."""
    return cv2.rectangle(picture, (128, 302), (512, 326), (20, 20, 60), -1)


@pytest.mark.parametrize(
    ('view', 'change', 'most'),
    [
        (BEHIND, lambda picture: picture, 5e-3),
        (SMALL, people_at_rails, 5e-3),
        (BEHIND, scoreboard, 3e-2),  # it hides what tells where the near nose is
    ],
    ids=['from behind', 'people at the rails', 'a scoreboard'],
)
def test_a_table_is_found_as_broadcasts_show_it(view, change, most):
    """Pockets and people hide corners of the cloth, and the far rail is narrow."""
    scene = Scene.load('pool_table')
    table = find_table(change(still('pool_table', view=view, cloth='green')), scene)
    at = np.stack(np.meshgrid([-1.1, 0.0, 1.1], [-0.5, 0.0, 0.5]), -1).reshape(-1, 2)
    pixels = view.pixel(np.insert(at, 2, scene.ball.radius, axis=1))
    seen = table.camera.to_plane(pixels, scene.ball.radius)
    turned = np.sign(seen[-1, 0])  # which end is the foot is not seen
    np.testing.assert_allclose(turned * seen, at, atol=most)


def leaned_over(picture, view, part):
    """Someone hides so large a part of the table, at its end that is far from the camera."""
    far = np.array([[x, y, 0.2] for x, y in ((0, -1), (0, 1), (1, 1), (1, -1))])
    far[:, 0] = 1.27 * (1.0 - 2.0 * part) + far[:, 0] * (2.54 * part + 0.5)
    far[:, 1] *= 0.9
    body = np.round(view.pixel(far)).astype(int)
    return cv2.fillPoly(picture.copy(), [body], (70, 60, 75), cv2.LINE_AA)


@pytest.mark.parametrize('cloth', ['pool', 'green'])
def test_a_table_with_a_hidden_side_is_refused_or_found_in_another_picture(cloth):
    """Its other noses fit a shorter table, whose sights are elsewhere."""
    scene = Scene.load('pool_table')
    picture = still('pool_table', view=BEHIND, cloth=cloth)
    hidden = leaned_over(picture, BEHIND, 0.33)
    with pytest.raises(NoTableError, match='hides a side'):
        find_table(hidden, scene)
    with pytest.raises(NoTableError, match='hides a side'):
        WatchedTable([hidden] * 3, scene, ['8'])
    watched = WatchedTable([hidden] * 3 + [picture], scene, ['8'])
    assert len(watched.table.sights.at) == 18
    assert 'off by centimetres' not in watched.table.note


def test_a_table_without_sights_is_found(monkeypatch):
    monkeypatch.setattr(rendered, 'SIGHT', rendered.WOOD)
    lamps = (*LAMPS, (0.0, 0.0, 3.0))  # no other test has them: backgrounds are kept
    table = find_table(still('pool_table', cloth='green', lamps=lamps), Scene.load('pool_table'))
    assert not table.has_sights
    np.testing.assert_allclose(table.camera.place[:2], SMALL.place[:2], atol=0.05)


def test_sights_find_a_table_if_something_covers_a_nose():
    """A cue and an arm lie along the far long side: the cloth ends at them."""
    scene, view = Scene.load('pool_table'), SMALL_OBLIQUE
    picture = still('pool_table', view=view, cloth='green')
    cover = np.insert([[-1.6, 0.55], [1.6, 0.62], [1.6, 0.9], [-1.6, 0.83]], 2, 0.1, axis=1)
    cv2.fillPoly(picture, [np.round(view.pixel(cover)).astype(int)], (70, 60, 75), cv2.LINE_AA)
    table = find_table(picture, scene)
    assert 8 <= len(table.sights.at) < 14
    assert 'off by centimetres' in table.note
    at = np.stack(np.meshgrid([-1.1, 0.0, 1.1], [-0.5, 0.0, 0.5]), -1).reshape(-1, 2)
    pixels = view.pixel(np.insert(at, 2, scene.ball.radius, axis=1))
    np.testing.assert_allclose(table.camera.to_plane(pixels, scene.ball.radius), at, atol=5e-3)


def test_balls_that_touch_are_two():
    scene = Scene.load('carom')
    radius = scene.ball.radius
    places = {'cue': (0.3, 0.2), 'red': (0.3 + 2.0 * radius, 0.2), 'yellow': (-0.6, -0.3)}
    scene = replace(scene, balls=places)
    filming = Filming(view=SMALL, hand=False)
    picture = Painter(scene, Motion(scene, 1, longest=0.1), filming).at(0.1)
    table = find_table(picture, scene)
    finder = BallFinder(table.camera, fit_cloth(picture, table.camera, 0.037), radius)
    seen = finder.find(picture)
    assert len(seen) == 3
    for place in places.values():
        assert np.linalg.norm(seen['place'] - place, axis=1).min() < 2e-3


def test_corners_may_be_clicked():
    picture = still()
    half = np.array([[1.42, 0.71, 0.037]]) * [[1, 1, 1], [1, -1, 1], [-1, 1, 1], [-1, -1, 1]]
    clicks = SMALL.pixel(half) + np.array([[1, -1], [2, 1], [0, 1], [-1, -1]])
    table = find_table(picture, Scene.load('carom'), clicks)
    assert table.error < 0.2


def test_half_a_table_is_refused():
    picture = still(view=replace(SMALL, at=(0.9, 0.0, 0.0)))
    with pytest.raises(NoTableError, match='reaches beyond the left edge'):
        cloth_corners(picture)


def test_no_table_is_refused(tmp_path, capsys):
    path = tmp_path / 'floor.mp4'
    draw = np.random.default_rng(1)
    with av.open(str(path), 'w') as out:
        stream = out.add_stream('libx264', rate=30)
        stream.width, stream.height, stream.pix_fmt = 320, 180, 'yuv420p'
        for _ in range(5):
            noise = cv2.GaussianBlur(draw.uniform(-3.0, 3.0, (180, 320, 3)), (0, 0), 4)
            picture = np.clip(128.0 + 500.0 * noise, 0, 255).astype(np.uint8)
            out.mux(stream.encode(av.VideoFrame.from_ndarray(picture, 'rgb24')))
        out.mux(stream.encode())
    words = ['calibrate', 'film', str(path), '-o', str(tmp_path / 'shots.csv')]
    assert main(words) == FAILED
    assert 'four clicks' in capsys.readouterr().err
    assert 'The table was not found' in (tmp_path / 'shots.html').read_text()
    assert not (tmp_path / 'shots.csv').exists()


@pytest.mark.parametrize(
    ('words', 'said'),
    [
        (['--corners', '1,2', '3', '4,5', '6,7'], 'four pixels'),
        (['--readout', '3'], 'at most 0.1'),
        ([], 'cannot be read as a film'),
    ],
)
def test_bad_input_is_named(words, said, tmp_path, capsys):
    path = tmp_path / 'no.mp4'
    path.write_text('this is no film')
    code = main(['calibrate', 'film', str(path), '-o', str(tmp_path / 'x.csv'), *words])
    assert code == WRONG_INPUT
    assert said in capsys.readouterr().err


def test_a_missing_library_is_named(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, 'av', None)
    code = main(['calibrate', 'film', str(tmp_path / 'any.mp4'), '-o', str(tmp_path / 'x.csv')])
    assert code == WRONG_INPUT
    assert "pip install 'billiard_shot[film]'" in capsys.readouterr().err


def test_a_film_may_be_upside_down():
    picture = np.ascontiguousarray(still(view=SMALL_OBLIQUE)[::-1, ::-1])
    table = find_table(picture, Scene.load('carom'))
    assert table.error < 0.2
    assert table.camera.rotation[1, 2] > UPSIDE_DOWN
    np.testing.assert_allclose(table.camera.place[2], SMALL_OBLIQUE.place[2], rtol=0.05)


class Leaning(Painter):
    """Someone leans over a third of the table after the second strike."""

    def at(self, time):
        picture = super().at(time)
        since = time - self.motion.starts[1]
        if 0.4 < since < 1.0:
            arm = np.array([[430, 0], [640, 0], [640, 250], [520, 300], [400, 230]])
            cv2.fillPoly(picture, [arm], (70, 60, 75))
            cv2.circle(picture, (410, 240), 18, (190, 140, 115), -1, cv2.LINE_AA)
        return picture


def test_what_is_hidden_or_begins_before_the_film_is_said_and_not_invented(tmp_path):
    path, scene = tmp_path / 'late.mp4', Scene.load('carom')
    filming = Filming(view=SMALL, rate=30.0)
    motion = Motion(scene, 2, longest=1.5)
    painter = Leaning(scene, motion, filming)
    write_film(path, painter, np.arange(motion.starts[0] + 0.5, motion.end, 1 / 30))
    result = read_film(path, scene, readout=filming.readout)
    assert any('begins before the film' in note for note in result.notes)
    (shot,) = result.shots
    assert abs(shot.strike + 0.5 * filming.exposure - motion.starts[1]) < 0.25 / 30
    hidden = [note for note in result.notes if 'pictures' in note and 'is seen in' in note]
    assert hidden, result.notes
    off, _ = errors_of(result, motion, filming)
    assert np.abs(off).max() < 0.01


def test_a_pocketed_ball_ends_its_track(tmp_path):
    path = tmp_path / 'pot.mp4'
    scene = Scene.load('pool_table')
    scene = replace(scene, balls={'cue': (0.7, 0.35), '8': (1.0, 0.5), '3': (-0.6, -0.2)})
    filming = Filming(view=SMALL, rate=30.0, cloth='pool')
    motion = filmed(path, scene, filming, seed=POTTING, longest=1.6, speed=(1.5, 2.0))
    fall = motion.times[np.argmax(motion.places['8'][:, 2] < 0.5 * scene.ball.radius)]
    assert motion.starts[0] < fall < motion.end - 1.0
    result = read_film(path, scene, readout=filming.readout)
    said = [note for note in result.notes if 'pocketed, or hidden' in note]
    assert len(said) == 1
    assert "'8' is not seen after" in said[0]
    assert fall - 0.2 < result.balls['8']['time'][-1] < fall + 0.05
    assert set(result.balls) == {'cue', '8', '3'}
    off, _ = errors_of(result, motion, filming)
    assert np.quantile(np.abs(off), 0.95) < 3e-3


def test_hdr_is_refused(tmp_path):
    path = tmp_path / 'hdr.mp4'
    with av.open(str(path), 'w') as out:
        stream = out.add_stream('libx264', rate=30)
        stream.width, stream.height, stream.pix_fmt = 320, 180, 'yuv420p10le'
        frame = av.VideoFrame.from_ndarray(np.zeros((180, 320, 3), np.uint8), 'rgb24')
        out.mux(stream.encode(frame.reformat(format='yuv420p10le')))
        out.mux(stream.encode())
    with pytest.raises(FilmError, match='turn HDR off'):
        Film(path).samples()


def test_a_green_ball_on_green_cloth_is_said_to_be_missing(tmp_path):
    path, scene = tmp_path / 'green.mp4', Scene.load('pool_table')
    scene = replace(scene, balls={'cue': (0.5, 0.1), '3': (-0.2, 0.1), '6': (0.1, -0.3)})
    filming = Filming(view=SMALL, rate=30.0, cloth='green')
    filmed(path, scene, filming, shots=1, longest=0.3)
    result = read_film(path, scene, readout=filming.readout)
    assert "ball '6' was not found" in result.notes
    assert set(result.balls) == {'cue', '3'}


def test_a_black_ball_in_a_dark_corner_is_found():
    lamps = ((0.75, 0.25, 1.0),)
    scene = replace(Scene.load('pool_table'), balls={'8': (-1.15, -0.5), '3': (0.1, 0.3)})
    filming = Filming(view=SMALL, hand=False, cloth='green', lamps=lamps)
    picture = Painter(scene, Placed(scene.balls, scene.ball.radius), filming)
    picture.motion.put(scene.balls)
    watched = WatchedTable([picture.at(0.0)], scene, ['8', '3'])
    balls = {ball.name: ball.place for ball in watched.balls(picture.at(0.0), 0.1)}
    assert balls.keys() == {'8', '3'}
    assert np.linalg.norm(balls['8'] - scene.balls['8']) < scene.ball.radius


def test_a_hand_that_shakes_is_taken_out(tmp_path):
    picture = still()
    moved = cv2.warpAffine(picture, np.float64([[1, 0, 2.4], [0, 1, -1.3]]), (640, 360))
    bed = np.zeros((360, 640), np.uint8)
    cv2.fillPoly(bed, [cloth_corners(picture).astype(np.int32)], 1)
    move = Steady(picture, bed).move(moved)
    np.testing.assert_allclose(move, [[1, 0, 2.4], [0, 1, -1.3]], atol=0.1)


@pytest.mark.slow
def test_variable_rates_hevc_and_a_moving_camera(tmp_path):
    path, scene = tmp_path / 'hand.mp4', Scene.load('carom')
    filming = Filming(view=SMALL, rate=30.0, shake=0.5)
    motion = Motion(scene, 1, seed=2, longest=1.5)
    times = np.arange(0.0, motion.end, 1 / 45) + np.random.default_rng(1).uniform(0, 0.01, 1)
    times = np.delete(times, [20, 21, 50])
    write_film(path, Painter(scene, motion, filming), times, 'libx265')
    result = read_film(path, scene, readout=filming.readout)
    assert any('the camera moves' in note for note in result.notes)
    off, _ = errors_of(result, motion, filming)
    assert np.median(np.abs(off)) < 0.7e-3
