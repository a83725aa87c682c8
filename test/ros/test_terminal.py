"""What a terminal shows: answers fit it, and strings from outside do not control it."""

from dataclasses import replace
from math import pi
import os

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.action import PlanShot
from ros2 import as_yaml
from std_msgs.msg import Header

from billiard_shot import plan, predict, Scene, Stroke
from billiard_shot.ros import conversions, plan_conversions
from billiard_shot.ros.client import say, TypedLines

SCREEN = 60
"""Lines."""

WIDTH = 80


@pytest.mark.parametrize(
    ('scene', 'stroke'),
    [
        ('paper', Stroke(normal=(-2, -1, 12), velocity=(4, 0, -16))),
        # many balls, cushions and changes of motion
        ('eight_ball', Stroke.from_offsets(a=0.1, b=0.1, elevation=0.08, azimuth=-0.1, speed=8.0)),
        ('pool_table', Stroke.from_offsets(a=0.4, b=0.2, elevation=0.1, azimuth=0.7, speed=4.0)),
        (
            'pool_table',
            Stroke.from_offsets(a=0.0, b=0.3, elevation=1.2, azimuth=pi / 3, speed=6.0),
        ),
    ],
)
def test_a_prediction_is_short(scene, stroke):
    shot = predict(Scene.load(scene), stroke)
    answer = conversions.response_of(shot, 0)
    assert 2 <= len(answer.trajectory.times) <= conversions.MAX_KEY_TIMES
    assert answer.trajectory.times[0] == 0.0
    assert answer.trajectory.times[-1] == shot.trajectory.duration
    printed = repr(answer)  # ros2 service call
    assert len(printed) <= 2 * SCREEN * WIDTH
    assert len(as_yaml(answer.trajectory).splitlines()) <= 2 * SCREEN


def test_a_plan_is_short_and_its_long_form_is_not():
    scene = replace(Scene.load('pool_table'), balls={'cue': (-0.4, 0.0), '8': (0.5, 0.2)})
    result = plan(scene, {'pot': '8'}, budget=20000, seed=4)
    assert len(result.ranking) > 1
    request = plan_conversions.PlanRequest(scene, {'pot': '8'}, scene.noise, {}, 20000, 4)

    def printed(**goal):
        goal = PlanShot.Goal(**goal)
        answer = plan_conversions.plan_result(result, request, '12345678', goal, Header())
        return len(as_yaml(answer).splitlines()), answer.plans[0].trajectory.times

    # Place, velocity and spin are printed a number a line, at few times by default.
    lines, times = printed()
    assert len(times) <= conversions.MAX_KEY_TIMES
    assert lines - 11 * len(times) <= 1.5 * SCREEN
    lines, _ = printed(plan_count=10, sample_count=200)
    assert lines > 2000 * len(result.ranking)


def test_strings_from_outside_do_not_control_the_terminal(capsys):
    say('shot \x1b[2J\x07\u202eé\nline two\r')
    assert capsys.readouterr().out == 'shot \\x1b[2J\\x07\\u202eé\nline two\\r\n'


def test_typed_lines_are_taken_one_by_one_without_waiting(monkeypatch):
    read, write = os.pipe()
    with os.fdopen(read) as typed, os.fdopen(write, 'wb', buffering=0) as keyboard:
        monkeypatch.setattr('sys.stdin', typed)
        lines = TypedLines()
        assert lines.next() is None
        keyboard.write(b' fire \n\xff\nno')
        assert [lines.next() for _ in range(3)] == ['fire', '\ufffd', None]
        keyboard.write(b'w\n')
        assert lines.next() == 'now'
        keyboard.close()
        assert lines.next() is None
