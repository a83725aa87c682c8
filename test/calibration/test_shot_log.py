"""Shots that a robot plays become lines of a recording."""

import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.calibration.reader import read_recording
from billiard_shot.calibration.recording import samples_of
from billiard_shot.calibration.shot_log import ShotLog
from billiard_shot.perception.sightings import Sighting

SCENE = Scene.load('carom')
STROKE = Stroke.from_offsets(0.2, 0.1, elevation_deg=3.0, azimuth_deg=20.0, speed=2.0)


def played(path, names=('one', 'two'), start=100.0):
    """Log shots that are seen 50 times a second, with a strike message that comes late."""
    log, written = ShotLog(path, 'carom'), []
    for name in names:
        shot = predict(SCENE, STROKE)
        for tick in range(-80, 51 * int(shot.run.duration + 2)):
            time = start + 0.02 * tick
            states = shot.run.at(max(0.02 * tick, 0.0))
            balls = {
                ball: Sighting(
                    tuple(state.position[:2].tolist()),
                    (1e-6, 0.0, 1e-6),
                    is_moving=bool(np.linalg.norm(state.velocity) > 0.01 and tick > 0),
                )
                for ball, state in states.items()
            }
            if ended := log.see(time, balls):
                written.append(ended.shot)
            if tick == 3:
                log.strike(name, start, STROKE)
        start = time + 1.0
    return written, shot


@pytest.fixture(scope='module')
def logged(tmp_path_factory):
    path = tmp_path_factory.mktemp('log') / 'shots.csv'
    return path, *played(path)


def test_each_strike_becomes_a_shot_with_its_stroke(logged):
    path, written, shot = logged
    assert written == ['one', 'two']
    recording = read_recording(path)
    assert [each.name for each in recording.shots] == ['one', 'two']
    assert (recording.scene, recording.ignored) == ('carom', ())
    for each in recording.shots:
        assert each.struck == 'cue'
        assert each.stroke.offsets == pytest.approx(STROKE.offsets, abs=1e-5)
        cue = each.tracks['cue']
        assert cue.time[0] == pytest.approx(-0.94, abs=0.03)
        assert shot.run.duration < cue.time[-1] < shot.run.duration + 1.2
        k = int(np.searchsorted(cue.time, 1.0))
        assert cue.place[k] == pytest.approx(
            shot.run.at(cue.time[k])['cue'].position[:2], abs=1e-4
        )
        assert samples_of(each).start == pytest.approx(0.0, abs=5e-3)


def test_a_log_goes_on_with_the_file_that_is_there(logged):
    path, *_ = logged
    assert played(path, ['three'], 500.0)[0] == ['three']
    recording = read_recording(path)
    assert [each.name for each in recording.shots] == ['one', 'two', 'three']
    assert recording.shots[0].stroke is not None


def test_the_balls_before_a_strike_are_those_of_the_last_picture_before_it(tmp_path):
    """Also if a strike is told after a picture of the moving ball: its stroke would be wrong."""
    log = ShotLog(tmp_path / 'shots.csv', 'carom')
    assert log.seen_before(1.0) == {}
    pictures = [{'cue': Sighting((x, 0.0))} for x in (0.1, 0.2, 0.3)]
    for time, balls in zip((1.0, 1.1, 1.2), pictures, strict=True):
        log.see(time, balls)
    assert log.seen_before(1.15) == pictures[1]
    assert log.seen_before(0.5) == pictures[0]
    log.strike('one', 1.15, STROKE)
    log.finish()
    log.strike('two', 1.25, STROKE)
    assert log.seen_before(1.25) == pictures[2]
