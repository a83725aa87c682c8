"""The tracker of balls as a real process: a camera in its own frame, and shots with its table."""

import math

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')
pytest.importorskip('vision_msgs', reason='needs vision_msgs')
pytest.importorskip('tf2_msgs', reason='needs tf2_msgs')

from billiard_shot_msgs.msg import BallState, Strike, TableState
from cell import PATIENT
from geometry_msgs.msg import Point, Quaternion, Transform, TransformStamped, Vector3
import numpy as np
from rclpy.time import Time
from std_msgs.msg import Header
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage
from vision_msgs.msg import Detection3D, Detection3DArray, ObjectHypothesisWithPose
from waiting import PATIENCE, PatientCaller, spin_until

from billiard_shot import Scene, Stroke
from billiard_shot.cue.plan import GoalOutcome
from billiard_shot.cue.safety import SafetyState
from billiard_shot.ros.node_runner import LATCHED
from billiard_shot.ros.table_sim import CameraErrors, detections_message
from billiard_shot.ros.table_tracker import Frames, STATIC

NOISE = 5e-4
CAMERA = {
    'camera': 'true',
    'detection_noise': str(NOISE),
    'detection_loss': '0.05',
    'detection_swap': '0.02',
}
SPACE = '/seen'
NODES = {
    **PATIENT,
    'table_sim': tuple(
        word for name, value in CAMERA.items() for word in ('-p', f'{name}:={value}')
    ),
    'table_tracker': (),
}


def transform(child, parent, way, half_turn, stamp=None):
    """Transform turned by twice `half_turn` about z."""
    return TransformStamped(
        header=Header(frame_id=parent, stamp=Time(seconds=stamp or 0).to_msg()),
        child_frame_id=child,
        transform=Transform(
            translation=Vector3(**dict(zip('xyz', way, strict=True))),
            rotation=Quaternion(z=math.sin(half_turn), w=math.cos(half_turn)),
        ),
    )


def frames_with(*moving, static=()):
    frames = Frames.__new__(Frames)
    frames._latest, frames.missing = {}, ''
    frames.hear(TFMessage(transforms=list(static)), True)
    frames.hear(TFMessage(transforms=list(moving)), False)
    return frames


def test_frames_are_connected_over_their_common_parent():
    frames = frames_with(
        static=[
            transform('table', 'world', (1.0, 0.0, 0.7), 0.0),
            transform('arm', 'world', (0.0, 2.0, 0.0), math.pi / 4),
            transform('camera', 'arm', (0.5, 0.0, 1.0), 0.0),
        ]
    )
    rotation, way = frames.between('camera', 'table', 0.0)
    # the camera is 0.5 m along the arm, which points along +y
    np.testing.assert_allclose(way, (-1.0, 2.5, 0.3), atol=1e-12)
    np.testing.assert_allclose(rotation @ (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), atol=1e-12)
    back, there = frames.between('table', 'camera', 0.0)
    np.testing.assert_allclose(back @ way + there, 0.0, atol=1e-12)
    np.testing.assert_allclose(frames.between('table', 'table', 0.0)[1], 0.0)


@pytest.mark.parametrize('length', [0.0, 0.5, 0.994, 1.006, 3.0, math.nan])
def test_only_a_quaternion_of_length_1_is_a_rotation(length):
    def between(length):
        turned = transform('camera', 'table', (1.0, 2.0, 0.0), math.pi / 4)
        rotation = turned.transform.rotation
        rotation.z, rotation.w = length * rotation.z, length * rotation.w
        return frames_with(static=[turned]).between('camera', 'table', 0.0)

    with pytest.raises(ValueError, match=r"transform of 'camera' must have the length 1, within"):
        between(length)
    turn, way = between(0.996)
    np.testing.assert_allclose(turn @ (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), atol=1e-12)
    np.testing.assert_allclose(way, (1.0, 2.0, 0.0))


def test_transforms_that_cannot_be_used_are_named():
    with pytest.raises(ValueError, match="'camera' is not known in 'table': no transform"):
        frames_with().between('camera', 'table', 0.0)
    old = frames_with(transform('camera', 'table', (0.0, 0.0, 1.0), 0.0, stamp=10))
    old.between('camera', 'table', 10.05)
    with pytest.raises(ValueError, match=r'must be within 0\.1 s of the position, got 1 s'):
        old.between('camera', 'table', 11.0)
    circle = frames_with(static=[transform(a, b, (0.0,) * 3, 0.0) for a, b in ('xy', 'yx')])
    with pytest.raises(ValueError, match='circle'):
        circle.between('x', 'table', 0.0)


def test_a_camera_in_its_own_frame(node, launch_once):
    """It looks from beside the table; one ball is hidden later, and one class id has a name."""
    names = "class_names:=['white=cue', '8']"
    launch_once('table_tracker', '-r', '__ns:=/tracked', '-p', names)
    heard = []
    node.create_subscription(TableState, '/tracked/table_state', heard.append, LATCHED)
    transforms = node.create_publisher(TFMessage, '/tf_static', STATIC)
    transforms.publish(
        TFMessage(transforms=[transform('camera', 'table', (0.0, 2.0, 1.0), math.pi / 4)])
    )
    camera = node.create_publisher(Detection3DArray, '/tracked/detections', 10)
    random = np.random.default_rng(1)
    # The axes of the camera are y and -x of the table.
    places = {'white': (-1.6, -0.3, -0.97), '8': (-2.2, 0.5, -0.97)}

    def see():
        header = Header(frame_id='camera', stamp=node.get_clock().now().to_msg())
        camera.publish(detections_message(places, CameraErrors(NOISE), random, header))

    timer = node.create_timer(1 / 30, see)

    def balls():
        return {ball.id: ball for ball in heard[-1].balls} if heard else {}

    assert spin_until(node, lambda: len(balls()) == 2 and not balls()['cue'].moving), heard[-1:]
    assert heard[-1].header.frame_id == 'table'
    for name, place in (('cue', (0.3, 0.4)), ('8', (-0.5, -0.2))):
        point, covariance = balls()[name].position, balls()[name].position_covariance
        assert math.dist((point.x, point.y), place) < 5 * NOISE
        assert 0.0 < covariance[0] < NOISE**2
        assert balls()[name].state == BallState.ON_TABLE
    del places['8']
    assert spin_until(node, lambda: balls()['8'].state == BallState.UNKNOWN)
    assert balls()['cue'].state == BallState.ON_TABLE
    last = balls()['8'].last_seen
    timer.cancel()
    count = len(heard)

    def repeats():
        """While nothing comes, it repeats the stamp of the last detection."""
        return len(heard) > count + 3 and heard[-1].header.stamp == heard[-2].header.stamp

    assert spin_until(node, repeats)
    assert balls()['8'].last_seen == last
    reset = PatientCaller(node, Trigger, '/tracked/table_tracker/reset')
    assert reset.wait_for_service()
    assert reset.call(Trigger.Request(), repeatable=True).success
    assert spin_until(node, lambda: not heard[-1].balls)


def test_a_detection_without_a_pose_has_the_centre_of_its_box(node, launch_once):
    launch_once('table_tracker', '-r', '__ns:=/boxes')
    heard = []
    node.create_subscription(TableState, '/boxes/table_state', heard.append, LATCHED)
    camera = node.create_publisher(Detection3DArray, '/boxes/detections', 10)

    def see():
        message = Detection3DArray(header=Header(stamp=node.get_clock().now().to_msg()))
        for score, x in ((0.9, 0.25), (0.1, -0.25)):
            result = ObjectHypothesisWithPose()
            result.hypothesis.class_id, result.hypothesis.score = 'cue', score
            detection = Detection3D(results=[result])
            detection.bbox.center.position.x = x
            message.detections.append(detection)
        camera.publish(message)

    timer = node.create_timer(1 / 30, see)
    assert spin_until(node, lambda: heard and heard[-1].balls)
    assert spin_until(node, lambda: not heard[-1].balls[0].moving)
    (ball,) = heard[-1].balls
    assert (ball.position.x, ball.position.y) == pytest.approx((0.25, 0.0))
    assert ball.position_covariance[0] > 0.0
    timer.cancel()


def test_shots_are_played_with_a_camera_and_a_moved_ball_is_noticed(node, cell):
    def rests():
        balls = cell.player.balls().values()
        return balls and not any(ball.is_moving for ball in balls)

    for _ in range(3):
        assert cell.player.until(rests, PATIENCE)
        stroke = Stroke.from_offsets(b=0.1, elevation=0.1, speed=0.4)
        result = cell.player.execute(cell.goal('seen', stroke)).result
        assert result.outcome == GoalOutcome.OK, result.message
        assert 'cue' in cell.player.wait_for_rest(result.strike.header.stamp)
    strikes = cell.player.create_publisher(Strike, '/seen/cue_driver/strike', 10)
    goal = cell.goal('moved')
    ended = cell.begin(goal)
    cell.reach(SafetyState.AIMED)
    played = cell.strikes[-1]  # somebody else moves the ball
    x, y = cell.player.balls()['cue'].position
    played.cue_pose.position = Point(x=x - Scene.load('paper').ball.radius, y=y, z=0.0286)
    played.header.stamp = node.get_clock().now().to_msg()
    strikes.publish(played)
    assert cell.player.until(ended.done, PATIENCE)
    assert ended.result().result.outcome == GoalOutcome.TABLE_MOVED
