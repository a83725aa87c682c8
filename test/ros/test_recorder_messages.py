"""Messages that a recorder of shots must survive, without any middleware."""

from types import SimpleNamespace

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.msg import BallState, Strike, TableState
from geometry_msgs.msg import Point, Pose, Quaternion
from std_msgs.msg import Header

from billiard_shot.calibration.reader import read_recording
from billiard_shot.calibration.shot_log import ShotLog
from billiard_shot.ros import shot_recorder
from billiard_shot.ros.conversions import stamp_of
from billiard_shot.ros.shot_recorder import ShotRecorder

RADIUS = 0.0286


class Recorder(ShotRecorder):
    """The node without its middleware: a clock, and a log that is a list."""

    def __init__(self, path):
        self.said, self.now = [], 100.0
        self._log = ShotLog(path, 'paper')
        self._frame, self._radius, self._curvature = 'table', RADIUS, 0.2
        self._heard, self._last = 0.0, ''

    def get_clock(self):
        now = SimpleNamespace(nanoseconds=round(1e9 * self.now))
        return SimpleNamespace(now=lambda: now)

    def get_logger(self):
        return SimpleNamespace(
            info=self.said.append, warning=self.said.append, error=self.said.append
        )

    def picture(self, ahead=0.0, moving=False):
        self.now += 0.02
        header = Header(frame_id='table', stamp=stamp_of(self.now + ahead))
        self._see(TableState(header=header, balls=[BallState(id='cue', moving=moving)]))

    def strike(self, shot_id='one', x=-RADIUS, y=0.0):
        pose = Pose(position=Point(x=x, y=y, z=RADIUS), orientation=Quaternion(w=1.0))
        header = Header(frame_id='table', stamp=stamp_of(self.now))
        self._strike(Strike(header=header, shot_id=shot_id, cue_pose=pose, speed=1.0))

    def shot(self, **strike):
        self.picture()
        self.strike(**strike)
        for k in range(80):
            self.picture(moving=k < 20)


@pytest.fixture
def recorder(tmp_path):
    return Recorder(tmp_path / 'shots.csv')


def shots_of(recorder):
    return [shot.name for shot in read_recording(recorder._log._path).shots]


@pytest.mark.parametrize('ahead', [60.0, 3600.0])
def test_a_picture_ahead_of_the_clock_loses_no_shot(recorder, ahead):
    recorder.picture(ahead)
    assert 's ahead of the clock, got' in recorder.said[0]
    recorder.shot()
    assert shots_of(recorder) == ['one']


@pytest.mark.parametrize(
    'past',
    [{'x': 2.0}, {'x': -2.0}, {'y': 1.0}, {'y': 0.03}],
    ids=['past', 'short', 'far', 'near'],
)
def test_a_strike_that_misses_the_ball_is_no_shot(recorder, past):
    recorder.shot(**past)
    assert recorder.said[0].startswith('ignored a strike: cue_pose')
    recorder.shot()
    assert shots_of(recorder) == ['one']


def test_a_camera_that_falls_silent_ends_the_shot(recorder, monkeypatch):
    recorder.picture()
    recorder.strike()
    recorder.picture(moving=True)
    recorder._listen()
    assert not recorder.said
    monkeypatch.setattr(shot_recorder, 'monotonic', lambda: recorder._heard + 2.1)
    recorder._listen()
    assert recorder.said == [
        "shot 'one' is recorded, but not to its end: there was no table state for 2 s"
    ]
    assert shots_of(recorder) == ['one']


def test_a_strike_that_is_repeated_is_one_shot_and_a_second_one_has_its_own_name(recorder):
    recorder.picture()
    recorder.strike()
    recorder.strike()
    recorder.picture(moving=True)
    assert not recorder.said
    recorder.shot()
    recorder.finish('the node has ended')
    assert recorder.said == [
        "shot 'one' is recorded, but not to its end: the next one has begun",
        "there is a shot 'one': this one is recorded as 'one_2'",
        "shot 'one_2' is recorded",
    ]
    assert shots_of(recorder) == ['one', 'one_2']
