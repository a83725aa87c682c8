"""Messages of a camera to detections of balls, without any middleware."""

from collections import Counter
import math
from types import SimpleNamespace

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')
pytest.importorskip('vision_msgs', reason='needs vision_msgs')

from builtin_interfaces.msg import Time
from hypothesis import example, given
from hypothesis import strategies as st
import numpy as np
from rclpy.serialization import serialize_message
from std_msgs.msg import Header
from vision_msgs.msg import Detection3D, Detection3DArray, ObjectHypothesisWithPose

from billiard_shot.perception.gate import MAX_DEVIATION
from billiard_shot.perception.tracker import BallTracker
from billiard_shot.ros import table_tracker
from billiard_shot.ros.conversions import stamp_of
from billiard_shot.ros.table_tracker import (
    class_counts_of,
    class_names_of,
    detected_balls,
    MAX_BYTES,
    TableTracker,
)

NAMES = {'white': 'cue', '8': '8', 'solid': 'solid'}
VARIANCE = 2.5e-7
HERE = np.eye(3), np.zeros(3)
ANY = st.floats(width=64)


def detection(class_id, x=0.0, y=0.0, covariance=(), score=1.0):
    """Detection with the covariance (9,) of its position."""
    result = ObjectHypothesisWithPose()
    result.hypothesis.class_id, result.hypothesis.score = class_id, score
    result.pose.pose.position.x, result.pose.pose.position.y = x, y
    for i, value in enumerate(covariance):
        result.pose.covariance[6 * (i // 3) + i % 3] = value
    return Detection3D(results=[result])


def read(*found, where=HERE):
    return detected_balls(found, NAMES, 0.5, VARIANCE, *where)


def test_only_classes_with_a_name_are_balls():
    balls, ignored = read(
        detection('white', 0.1),
        detection('person', 0.2),
        detection('8', 0.3),
        detection('9', 0.4, score=0.1),
        Detection3D(),
    )
    assert [(each.kind, each.position) for each in balls] == [
        ('cue', (0.1, 0.0)),
        ('8', (0.3, 0.0)),
    ]
    assert ignored == ["class_id must be in class_names, got 'person'"]


@pytest.mark.parametrize(
    'covariance',
    [
        (-1e-6, 0, 0, 0, -1e-6, 0, 0, 0, 0),
        (4e-5, 0, 0, 0, 1e-6, 0, 0, 0, 0),
        (1e-6, 5e-7, 0, 0, 1e-6, 0, 0, 0, 0),
    ],
)
def test_a_detection_that_is_too_uncertain_is_no_ball(covariance):
    balls, (ignored,) = read(detection('8', covariance=covariance))
    assert not balls
    assert ignored.startswith("covariance of '8' must be symmetric and positive semi-definite")


def test_the_uncertainty_counts_in_the_frame_of_the_table():
    """The camera looks along y of the table, and knows distances to 20 mm only."""
    sideways = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]), np.zeros(3)
    from_above = detection('8', covariance=(1e-6, 0, 0, 0, 1e-6, 0, 0, 0, 4e-4))
    (ball,), _ = read(from_above)
    assert ball.covariance == (1e-6, 0.0, 1e-6)
    balls, ignored = read(from_above, where=sideways)
    assert (len(balls), len(ignored)) == (0, 1)


@given(ANY, ANY, st.lists(ANY, min_size=9, max_size=9), ANY)
@example(1e308, 1e308, [0.0] * 9, 1.0)
@example(1e160, 0.0, [1e308] * 9, 1.0)
def test_any_numbers_are_a_ball_or_ignored(x, y, covariance, score):
    turned = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]), np.full(3, 0.1)
    balls, ignored = read(detection('8', x, y, covariance, score), where=turned)
    if not score >= 0.5:
        assert not balls
        assert not ignored
        return
    assert len(balls) + len(ignored) == 1
    for ball in balls:
        xx, xy, yy = ball.covariance
        assert max(map(abs, ball.position)) <= 10.0
        assert xx * yy > xy * xy
        assert max(xx, yy) <= MAX_DEVIATION**2


def test_too_many_balls_are_counted_before_anything_else_is_done(monkeypatch):
    def never(*_):
        raise AssertionError('a position was read')

    monkeypatch.setattr(table_tracker, 'xyz', never)
    with pytest.raises(
        ValueError, match=r'detections of balls must have at most 64 .*, got 10000'
    ):
        read(*[detection('8')] * 10_000)
    balls, ignored = read(*[detection('person')] * 10_000)
    assert (len(balls), len(ignored)) == (0, 10_000)


@pytest.mark.parametrize(
    'entry',
    ['', '=', 'white=', '=cue', 'solid\n', 'x' * 62, 'cue*2', 'solid*0', 'solid*65', 'a=b=c'],
)
def test_names_that_no_ball_can_have(entry):
    with pytest.raises(ValueError, match=r'^class_names must be'):
        class_names_of([entry])
    names = class_names_of(['8', 'white=cue', 'yellow=solid*7', 'stripe*7'])
    assert names == {'8': '8', 'white': 'cue', 'yellow': 'solid', 'stripe': 'stripe'}


def test_a_class_has_the_number_that_is_stated_or_that_of_the_scene():
    balls = ['cue', '8', 'stripe', 'stripe_2', 'solid']
    counts = class_counts_of(['white=cue', 'yellow=solid*7', 'stripe'], balls)
    assert counts == {'cue': 1, '8': 1, 'stripe': 2, 'solid': 7}


class Hearing:
    """The tracker node without middleware: its tracker, its log, and the tables it publishes."""

    def __init__(self, now=100.0):
        self.tracker, self.log, self.published = BallTracker(0.0286), [], 0
        self.now = now

    def hear(self, found, stamp):
        message = Detection3DArray(header=Header(stamp=stamp), detections=found)
        node = SimpleNamespace(
            get_clock=lambda: SimpleNamespace(
                now=lambda: SimpleNamespace(nanoseconds=round(1e9 * self.now))
            ),
            get_parameter=lambda _: SimpleNamespace(value='table'),
            get_logger=lambda: SimpleNamespace(
                warning=lambda text, **_: self.log.append(text),
                info=lambda text, **_: self.log.append(text),
            ),
            _frames=SimpleNamespace(between=lambda *_: HERE),
            _reading=(NAMES, 0.5, VARIANCE),
            _detections_type=Detection3DArray,
            _ignored=Counter(),
            _told=-math.inf,
            _tracker=self.tracker,
            _repeat=SimpleNamespace(reset=lambda: None),
            _publish=self._publish,
        )
        TableTracker._on_detections(node, serialize_message(message))

    def _publish(self):
        self.published += 1


def test_a_stamp_ahead_of_the_clock_is_no_picture():
    camera = Hearing()
    for ahead in (3600.0, 0.2):
        camera.hear([detection('8')], stamp_of(camera.now + ahead))
    assert (camera.published, camera.tracker.time) == (0, 0.0)
    assert 'header.stamp must be at most 0.1 s ahead of the clock, got 3.6e+03 s' in camera.log[0]
    camera.hear([detection('8')], stamp_of(camera.now + 0.05))
    assert (camera.published, camera.tracker.time) == (1, pytest.approx(100.05))


def test_an_empty_message_is_a_picture():
    camera = Hearing()
    camera.hear([], stamp_of(99.0))
    camera.hear([detection('person'), detection('8', math.nan)], Time())  # without a stamp: now
    assert (camera.published, camera.tracker.time) == (2, 100.0)
    (said,) = camera.log
    assert said.startswith('ignored 2 detections: class_id must be in class_names, got ')
    assert said.endswith("position of '8'.x must be from -10 to 10 m, got nan (1 times)")


def test_a_huge_message_is_not_even_read(monkeypatch):
    camera = Hearing()
    monkeypatch.setattr('billiard_shot.ros.table_tracker.deserialize_message', None)
    camera.hear([detection('8')] * 2000, stamp_of(100.0))
    assert camera.published == 0
    assert f'detections must have at most {MAX_BYTES} bytes, got ' in camera.log[0]
