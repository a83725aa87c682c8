"""Videos of shots: what an image shows is where the balls are; the files come out."""

from pathlib import Path
import re
import sys

import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.cli import main

pytest.importorskip('matplotlib')  # an extra

from billiard_shot.pictures.canvas import ball_colour, CUE_BALL_COLOUR
from billiard_shot.pictures.table import END_SHOWN, image_times, images, RATE, write_video
from billiard_shot.pictures.trails import cue_motion, OFF_CLOTH, trails_of
from billiard_shot.table.run.outline import outline_of

SCENE = Scene.load('frozen_combination')
SHOT = predict(SCENE, Stroke.from_offsets(a=0, b=0.1, elevation=0.1, azimuth=0.55, speed=2))
NO_STROKE = predict(SCENE, Stroke((-1, 0, 0), (-1, 0, 0)))
WOOD = (0xC9, 0xAD, 0x8C)


def rgb(colour):
    return tuple(int(part, 16) for part in re.findall('..', colour.removeprefix('#')))


def colour_at(image, scene, place):
    """Return the colour that an image shows at a place (2,) [m]; the wood gives the scale."""
    rows, columns = np.nonzero((image == WOOD).all(axis=-1))
    half = outline_of(scene).frame
    low = np.array([columns.min(), rows.max() + 1.0])
    high = np.array([columns.max() + 1.0, rows.min()])
    column, row = low + (place + half) / (2.0 * half) * (high - low)
    return tuple(image[int(row), int(column)].tolist())


def test_balls_are_drawn_where_they_are():
    trails = trails_of(SHOT)
    times = image_times(SHOT)
    empty = next(images(SHOT, times[:1]))
    times = times[times > 0.3][::10]  # the cue is gone
    for time, image in zip(times, images(SHOT, times), strict=True):
        for name, ball in trails.balls.items():
            state = ball.at(time)
            if state.motion in OFF_CLOTH:
                continue
            shown = colour_at(image, SCENE, state.position[:2])
            if name == 'cue':
                assert shown == pytest.approx(rgb(CUE_BALL_COLOUR), abs=6)
            elif trails.moved(name):
                assert shown != colour_at(empty, SCENE, state.position[:2]), (name, time)


def test_paths_end_at_the_balls():
    """A path goes on between the points that draw it: behind a moving ball is its path."""
    trails = trails_of(SHOT)
    dark = 0
    times = [0.15, 1.0, 1.5]  # the cue ball slides, then rolls far
    for time, image in zip(times, images(SHOT, np.array(times)), strict=True):
        state = trails.balls['cue'].at(time)
        way = state.velocity[:2] / np.linalg.norm(state.velocity[:2])
        behind = [
            state.position[:2] - (1.0 + part) * 0.0286 * way for part in (0.2, 0.4, 0.6, 0.8)
        ]
        dark += min(sum(colour_at(image, SCENE, place)) for place in behind) < 300
    assert dark == len(times)


def test_pocketed_ball_disappears():
    (last,) = images(SHOT, image_times(SHOT)[-1:])
    assert trails_of(SHOT).end('8') is None
    place = SHOT.run.balls['8'].at(60.0).position[:2]
    assert colour_at(last, SCENE, place) != pytest.approx(rgb(ball_colour('8')), abs=6)


def test_video_begins_with_the_cue_and_ends_after_the_last_ball():
    times, trails = image_times(SHOT), trails_of(SHOT)
    motion = cue_motion(SHOT, trails)
    assert times[0] == -motion.time
    assert trails.until + END_SHOWN <= times[-1] < trails.until + END_SHOWN + 1.01 / RATE
    assert np.diff(times) == pytest.approx(1.0 / RATE)
    assert motion.way(times[0]) == pytest.approx(-motion.swing * motion.direction)
    assert motion.way(0.0) == pytest.approx(0.0)
    # The speed just before the strike is that of the stroke, and the one after it the shot's.
    step = 1e-7
    before, after = motion.way(-step) / -step, motion.way(step) / step
    assert before == pytest.approx(np.array(SHOT.stroke.velocity), rel=1e-4)
    assert np.linalg.norm(after) == pytest.approx(SHOT.cue_speed)


def test_gif(tmp_path):
    from PIL import Image

    counts = []
    write_video(SHOT, tmp_path / 'shot.gif', 'a title', counts.append)
    with Image.open(tmp_path / 'shot.gif') as gif:
        # Images that are alike at the end may be one that is shown longer.
        durations = []
        for number in range(gif.n_frames):
            gif.seek(number)
            durations.append(gif.info['duration'])
    times = image_times(SHOT)
    assert sum(durations) == pytest.approx(1000.0 * len(times) / RATE)
    assert counts[-1] == len(times)


def test_mp4(tmp_path, capsys):
    encoder = pytest.importorskip('imageio_ffmpeg')
    file = tmp_path / 'shot.mp4'
    stroke = ['-b', '0.1', '-e', '6', '-z', '31.5', '-s', '2']
    assert main(['view', 'frozen_combination', *stroke, '--video', str(file)]) == 0
    assert capsys.readouterr().out == f'{file}\n'
    count, seconds = encoder.count_frames_and_secs(str(file))
    assert count > 50
    assert seconds == pytest.approx(count / RATE, abs=0.05)


def test_refusals(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r'video must be a file .gif or .mp4, got .*shot.avi'):
        write_video(SHOT, tmp_path / 'shot.avi')
    assert NO_STROKE.status.refused
    with pytest.raises(ValueError, match=NO_STROKE.status.name):
        write_video(NO_STROKE, tmp_path / 'shot.gif')
    with pytest.raises(ValueError, match='nowhere'):
        write_video(SHOT, Path('/nowhere/shot.gif'))
    monkeypatch.setitem(sys.modules, 'imageio', None)
    with pytest.raises(ValueError, match=r"pip install 'billiard_shot\[video\]'"):
        write_video(SHOT, tmp_path / 'shot.mp4')
    assert list(tmp_path.iterdir()) == []
