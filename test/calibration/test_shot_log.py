"""Shots that a robot plays become lines of a recording."""

import numpy as np
import pytest

from billiard_shot import predict, Scene, Stroke
from billiard_shot.calibration.reader import read_recording
from billiard_shot.calibration.recording import samples_of
from billiard_shot.calibration.shot_log import ShotLog, ShotLostError, Written
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


# --- pictures and clocks that a recorder of shots must survive: nothing is lost without a word

LOGGED = Stroke.from_offsets(b=0.1, speed=1.0)
PERIOD = 0.02


class Table:
    """A cue ball that rolls at 1 m/s for a second after each strike, seen 50 times a second."""

    def __init__(self, path):
        self.log, self.now, self.struck, self.ended = ShotLog(path, 'carom'), 100.0, -9.0, []

    def see(self, seconds):
        for _ in range(round(seconds / PERIOD)):
            self.now += PERIOD
            rolled = min(max(self.now - self.struck, 0.0), 1.0)
            ball = Sighting((rolled, 0.1), is_moving=0.0 < rolled < 1.0)
            if written := self.log.see(self.now, {'cue': ball}):
                self.ended.append(written)

    def shot(self, name):
        self.struck = self.now
        name = self.log.strike(name, self.now, LOGGED)
        self.see(3.0)
        return name


@pytest.fixture
def path(tmp_path):
    return tmp_path / 'shots.csv'


def test_a_clock_that_is_set_back_ends_a_shot_and_loses_no_later_one(path):
    table = Table(path)
    table.see(1.0)
    table.struck = table.now
    table.log.strike('one', table.now, LOGGED)
    table.see(0.5)
    table.now -= 5.0
    table.struck -= 5.0
    table.see(1.0)
    assert table.ended == [Written('one', 'the clock was set back by 4.98 s')]
    table.shot('two')
    assert table.ended[1:] == [Written('two', '')]
    one, two = read_recording(path).shots
    assert one.tracks['cue'].time[-1] == pytest.approx(0.5, abs=0.03)
    assert two.tracks['cue'].time[-1] > 1.5


def test_a_strike_that_is_told_before_the_first_picture_of_a_new_clock_is_a_shot(path):
    table = Table(path)
    table.see(1.0)
    table.now -= 5.0
    table.shot('one')
    assert table.ended == [Written('one', '')]
    (shot,) = read_recording(path).shots
    assert 0.0 < shot.tracks['cue'].time[0] < 0.05


def test_two_shots_of_one_name_are_two_shots(path):
    table = Table(path)
    table.see(1.0)
    assert [table.shot('one'), table.shot('one')] == ['one', 'one_2']
    again = Table(path)
    again.now = 200.0
    again.see(1.0)
    assert [again.shot('x' * 64), again.shot('one')] == ['x' * 64, 'one_3']
    assert again.shot('x' * 64) == 'x' * 56 + '_2'
    assert len(read_recording(path).shots) == 5


def test_a_shot_whose_pictures_end_is_written_as_far_as_it_was_seen(path):
    table = Table(path)
    table.see(1.0)
    table.log.strike('one', table.now, LOGGED)
    table.struck = table.now
    table.see(0.4)
    assert table.log.finish('no pictures') == Written('one', 'no pictures')
    assert not table.log.finish('no pictures')
    (shot,) = read_recording(path).shots
    assert shot.tracks['cue'].time[-1] == pytest.approx(0.4, abs=0.03)


def test_a_ball_that_was_lost_as_it_moved_does_not_hold_up_the_end(path):
    table = Table(path)
    table.log.strike('one', 100.0, LOGGED)
    lost = Sighting((0.9, 0.1), is_moving=True, is_seen=False)
    for k in range(60):
        if written := table.log.see(100.0 + k * PERIOD, {'cue': Sighting((0, 0)), '8': lost}):
            break
    assert written == Written('one', '')


@pytest.mark.parametrize(
    ('csv', 'yaml', 'said'),
    [
        ('shot,time,ball,x,y\n1,0,white,0,0\n', '', r'shots\.csv: the header must be shot,time'),
        ('', '{scene: snooker}', r"shots\.yaml: scene must be 'carom', got 'snooker'"),
        ('', '{struck: white}', r"shots\.yaml: struck must be 'cue', got 'white'"),
        ('', '[1, 2]', r'shots\.yaml: must be the description of a recording'),
        ('', '{', r'shots\.yaml: must be the description of a recording'),
    ],
)
def test_a_file_of_something_else_is_refused_by_name_and_kept(path, csv, yaml, said):
    path.write_text(csv)
    path.with_suffix('.yaml').write_text(yaml)
    with pytest.raises(ValueError, match=said):
        ShotLog(path, 'carom')
    assert path.read_text() == csv
    assert path.with_suffix('.yaml').read_text() == yaml


def test_a_shot_that_cannot_be_written_is_told_and_the_next_one_is_written(path):
    table = Table(path)
    table.see(1.0)
    path.mkdir()
    with pytest.raises(ShotLostError, match=r"shot 'one' is lost: .*directory"):
        table.shot('one')
    path.rmdir()
    table.see(1.0)
    table.shot('two')
    assert [shot.name for shot in read_recording(path).shots] == ['two']


def test_a_strike_has_the_balls_of_its_own_second(path):
    table = Table(path)
    table.see(5.0)
    table.shot('one')
    (shot,) = read_recording(path).shots
    assert shot.tracks['cue'].time[0] == pytest.approx(-1.0, abs=0.03)
