"""Every kind of bad request: its status, a message that names the field, and a node that lives."""

import math
import time

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')

from billiard_shot_msgs.srv import PredictShot
from paper import request_for
from waiting import PatientCaller

from billiard_shot import Scene, Status, Stroke
from billiard_shot.ros.predict_shot import request_of
from billiard_shot.ros.predictor import SHOW_DELAY

RADIUS = Scene.load('paper').ball.radius
NAN, INF = math.nan, math.inf

# what is set, to what, status, what the message must say
BAD = [
    ('speed', 0.0, Status.INVALID_STROKE, 'speed must be finite and above 0 m/s, got 0.0'),
    ('speed', NAN, Status.INVALID_STROKE, 'got nan'),
    ('speed', INF, Status.INVALID_STROKE, 'got inf'),
    ('cue_pose.position.x', NAN, Status.INVALID_STROKE, 'position.x must be finite, got nan'),
    (
        'cue_pose.orientation.w',
        NAN,
        Status.INVALID_STROKE,
        'cue_pose, speed: orientation must have the length 1, within 0.005, got (',
    ),
    (
        'cue_pose.orientation',
        (0.0, 0.0, 0.0, 0.5),
        Status.INVALID_STROKE,
        'got (0.0, 0.0, 0.0, 0.5)',
    ),
    ('cue_pose.position.y', 0.1, Status.MISS, ''),
    ('cue_pose.orientation', (0.0, -0.05, 0.0, 1.0), Status.NEGATIVE_ELEVATION, 'elevation'),
    ('ball_position.x', NAN, Status.INVALID_REQUEST, 'ball_position.x must be from -10 to 10 m'),
    ('ball_position.y', 1e160, Status.INVALID_REQUEST, 'got 1e+160'),
    ('ball_position.z', -0.01, Status.INVALID_REQUEST, 'ball_position.z must be 0'),
    ('ball_position.z', 0.01, Status.INVALID_REQUEST, 'got 0.01 m'),
    ('header.frame_id', 'map', Status.INVALID_REQUEST, "frame_id must be 'table' or empty"),
    ('tolerance', -1e-4, Status.INVALID_REQUEST, 'tolerance must be finite'),
    ('tolerance', NAN, Status.INVALID_REQUEST, 'got nan'),
    ('tolerance', INF, Status.INVALID_REQUEST, 'got inf'),
    ('sample_count', 4_000_000_000, Status.INVALID_REQUEST, 'sample_count must be at most'),
]


def put(message, path, value):
    *parents, field = path.split('.')
    for parent in parents:
        message = getattr(message, parent)
    if isinstance(value, tuple):
        message = getattr(message, field)
        message.x, message.y, message.z, message.w = value
    else:
        setattr(message, field, value)


def level_shot():
    return request_of(Stroke((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0)), Scene.load('paper'))


@pytest.mark.parametrize(('path', 'value', 'status', 'words'), BAD)
def test_bad_request(ask, path, value, status, words):
    good = level_shot()
    assert ask(good).status == Status.OK, 'before'
    request = level_shot()
    put(request, path, value)
    answer = ask(request)
    assert Status(answer.status) is status, answer.message
    assert words in answer.message
    assert answer.message
    assert not answer.trajectory.times
    assert not answer.effects
    assert ask(good).status == Status.OK, 'the node keeps answering'


def test_cue_through_cloth(start, node):
    """pool: this scene knows how thick the cue is."""
    start('-p', 'scene:=pool', '-r', '__ns:=/pool')
    client = PatientCaller(node, PredictShot, '/pool/predict_shot')
    assert client.wait_for_service()
    request = level_shot()
    request.cue_pose.position.z = 0.005
    answer = client.call(request, repeatable=True)
    assert Status(answer.status) is Status.CUE_THROUGH_CLOTH
    assert 'cloth' in answer.message


def test_a_ball_that_cannot_lie_there(start, node):
    """blocked: by default the ball is at the origin, where another one lies."""
    start('-p', 'scene:=blocked', '-r', '__ns:=/blocked')
    client = PatientCaller(node, PredictShot, '/blocked/predict_shot')
    assert client.wait_for_service()
    request = level_shot()
    for x, words in (
        (0.0, ', which it overlaps by '),
        (5.0, 'ball_position must be between the cushions'),
    ):
        request.ball_position.x = x
        request.cue_pose.position.x = x - 0.2
        answer = client.call(request, repeatable=True)
        assert Status(answer.status) is Status.INVALID_REQUEST
        assert answer.message.startswith('ball_position must be ')
        assert words in answer.message
        assert not answer.trajectory.times


@pytest.mark.parametrize('value', [1e-300, 1e-12, 1e12, 1e300])
def test_absurd_speeds_get_finite_answers(ask, value):
    request = request_for('massé')
    request.speed = value
    answer = ask(request)
    numbers = [
        answer.velocity.x,
        answer.spin.y,
        answer.cue_speed,
        answer.error_estimate,
        *answer.trajectory.positions,
        *answer.trajectory.velocities,
    ]
    assert all(map(math.isfinite, numbers))
    assert answer.message
    time.sleep(2 * SHOW_DELAY)
    assert ask(level_shot()).trajectory.times, 'nor does showing such a shot end the node'
