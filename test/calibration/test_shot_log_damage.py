"""Pictures and clocks that a recorder of shots must survive: nothing is lost without a word."""

import pytest

from billiard_shot import Stroke
from billiard_shot.calibration.reader import read_recording
from billiard_shot.calibration.shot_log import ShotLog, ShotLostError, Written
from billiard_shot.perception.sightings import Sighting

STROKE = Stroke.from_offsets(b=0.1, speed=1.0)
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
        name = self.log.strike(name, self.now, STROKE)
        self.see(3.0)
        return name


@pytest.fixture
def path(tmp_path):
    return tmp_path / 'shots.csv'


def test_a_clock_that_is_set_back_ends_a_shot_and_loses_no_later_one(path):
    table = Table(path)
    table.see(1.0)
    table.struck = table.now
    table.log.strike('one', table.now, STROKE)
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
    table.log.strike('one', table.now, STROKE)
    table.struck = table.now
    table.see(0.4)
    assert table.log.finish('no pictures') == Written('one', 'no pictures')
    assert not table.log.finish('no pictures')
    (shot,) = read_recording(path).shots
    assert shot.tracks['cue'].time[-1] == pytest.approx(0.4, abs=0.03)


def test_a_ball_that_was_lost_as_it_moved_does_not_hold_up_the_end(path):
    table = Table(path)
    table.log.strike('one', 100.0, STROKE)
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
