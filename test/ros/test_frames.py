"""Frames: their names, and the transforms from the table to the tip of the cue."""

import os
import signal
from types import SimpleNamespace

import pytest

pytest.importorskip('rclpy', reason='needs ROS 2')

from billiard_shot_msgs.msg import BallState, TableState
from billiard_shot_msgs.srv import PredictShot
from builtin_interfaces.msg import Time
from nav_msgs.msg import Path
import numpy as np
from paper import request_for
from sensor_msgs.msg import JointState
from std_msgs.msg import Header, String
from visualization_msgs.msg import MarkerArray
from waiting import PATIENCE, PatientCaller, spin_until

from billiard_shot import Status
from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.cue.model import forward_kinematics, joints_of, urdf_of
from billiard_shot.cue.model import transforms as model_transforms
from billiard_shot.ros import conversions, parameters, plan_conversions
from billiard_shot.ros.node_runner import LATCHED
from billiard_shot.scene import Scene

CELL = ('-r', '__ns:=/cell1', '-p', 'frame:=cell1/table')
RADIUS = Scene.load('paper').ball.radius


def heard(node, kind, topic):
    """Message on a latched topic."""
    messages = []
    subscription = node.create_subscription(kind, topic, messages.append, LATCHED)
    arrived = spin_until(node, lambda: messages)
    node.destroy_subscription(subscription)
    assert arrived, f'{topic}: nothing came'
    return messages[-1]


def test_the_nodes_use_the_frame_that_they_are_given(node, launch):
    launch('predictor', *CELL)
    launch('table_sim', *CELL)
    client = PatientCaller(node, PredictShot, '/cell1/predict_shot')
    assert client.wait_for_service()
    request = request_for('horizontal')
    assert request.header.frame_id == 'table'
    refused = client.call(request, repeatable=True)
    assert refused.status == Status.INVALID_REQUEST
    assert refused.message == "header.frame_id must be 'cell1/table' or empty, got 'table'"
    for frame in ('cell1/table', ''):
        request.header.frame_id = frame
        assert client.call(request, repeatable=True).status == Status.OK
    path = heard(node, Path, '/cell1/predictor/path')
    assert {path.header.frame_id, path.poses[-1].header.frame_id} == {'cell1/table'}
    shown = heard(node, MarkerArray, '/cell1/predictor/markers')
    assert {marker.header.frame_id for marker in shown.markers} == {'cell1/table'}
    table = heard(node, TableState, '/cell1/table_state')
    assert table.header.frame_id == 'cell1/table'


def test_predictor_and_planner_refuse_balls_in_another_frame():
    from billiard_shot_msgs.action import PlanShot

    table = TableState(header=Header(frame_id='map'), balls=[BallState(id='cue')])
    scene = Scene.load('paper')
    with pytest.raises(ValueError, match=r"table_state\.header\.frame_id must be 'table' or em"):
        plan_conversions.plan_request_of(
            PlanShot.Goal(), SimpleNamespace(scene=scene), table, 'table'
        )
    with pytest.raises(
        ValueError, match=r"table_state\.header\.frame_id must be 'cell2/table' or"
    ):
        conversions.place_balls(
            PredictShot.Request(use_table_state=True), scene, table, 'cell2/table'
        )


@pytest.mark.parametrize('name', ['', ' ', '/table', 'cell1/', 'pool table'])
def test_names_that_no_frame_can_have(name):
    with pytest.raises(ValueError, match=r'frame must be .*, got .*'):
        parameters.check_frame_name(name)


# --- transforms ---------------------------------------------------------------------------------

MECHANISM = Mechanism()


def listening(node, kind, topic):
    """Messages on a topic that is not latched, as they come in."""
    messages = []
    node.create_subscription(kind, topic, messages.append, 100)
    return messages


def place_in(message, frame, root):
    """Position and direction of +x of a frame in the root of a message's transforms."""
    parents = {each.child_frame_id: each for each in message.transforms}
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    while frame != root:
        step = parents[frame].transform
        turn, way = step.rotation, step.translation
        axis, w = np.array([turn.x, turn.y, turn.z]), turn.w
        points = points + 2 * np.cross(axis, np.cross(axis, points) + w * points)
        points += [way.x, way.y, way.z]
        frame = parents[frame].header.frame_id
    return points[0], points[1] - points[0]


def joints_at(position, stamp):
    return conversions.joints_message(JOINTS, np.array(position), np.zeros(6), stamp)


def test_the_cue_is_published_as_model_and_transforms(node, launch):
    tf2_msgs = pytest.importorskip('tf2_msgs.msg', reason='needs tf2_msgs')
    launch('cue_model', '-r', '__ns:=/cell3', '-p', 'frame:=cell3/table')
    model = heard(node, String, '/cell3/robot_description')
    assert model.data == urdf_of(MECHANISM, 'cell3/table')
    transforms = listening(node, tf2_msgs.TFMessage, '/tf')
    publisher = node.create_publisher(JointState, '/cell3/joint_states', 10)
    rng = np.random.default_rng(3)
    for number in range(1, 4):
        joints = [rng.uniform(axis.min, axis.max) for axis in MECHANISM.axes]
        stamp = Time(sec=number, nanosec=5)

        def shown(joints=joints, stamp=stamp):
            publisher.publish(joints_at(joints, stamp))
            return transforms and transforms[-1].transforms[0].header.stamp == stamp

        assert spin_until(node, shown)
        message = transforms[-1]
        assert {each.header.stamp.sec for each in message.transforms} == {number}
        tip = forward_kinematics(MECHANISM, joints)
        position, along = place_in(message, 'cell3/tip', 'cell3/table')
        np.testing.assert_allclose(position, tip.position, atol=1e-12)
        np.testing.assert_allclose(along, tip.along, atol=1e-12)
        base, _ = place_in(message, 'cell3/base_link', 'cell3/table')
        np.testing.assert_allclose(base, joints[:3], atol=1e-12)


def test_joints_that_are_not_known_publish_no_transforms():
    for broken in ([np.nan, 0, 0.5, 0, 0.5, 0], [0, 0, 0.5, 0, 5.0, 0]):
        with pytest.raises(
            ValueError, match=r'base_x: position nan is not finite|incline: 5 m is'
        ):
            model_transforms(MECHANISM, joints_of(MECHANISM), broken)


def test_without_tf2_msgs_the_model_is_published_and_one_line_says_so(
    node, launch, tmp_path, monkeypatch
):
    (tmp_path / 'tf2_msgs').mkdir()
    (tmp_path / 'tf2_msgs' / '__init__.py').write_text('raise ImportError("hidden by a test")\n')
    with monkeypatch.context() as patch:
        patch.setenv('PYTHONPATH', str(tmp_path), prepend=os.pathsep)
        process = launch('cue_model', '-r', '__ns:=/cell4')
    assert heard(node, String, '/cell4/robot_description').data == urdf_of(MECHANISM)
    output = ''
    while 'ready: ' not in output:  # it publishes the model before that
        output += process.stdout.readline()
        assert process.poll() is None, output
    process.send_signal(signal.SIGINT)
    output += process.communicate(timeout=PATIENCE)[0]
    assert output.count('no transforms on /tf: the package tf2_msgs is missing') == 1
    assert process.returncode == 0
