"""The node that detects balls in pictures: its messages, and its life."""

import pytest

pytest.importorskip('billiard_shot_msgs', reason='needs ROS 2')
pytest.importorskip('vision_msgs', reason='needs vision_msgs')
pytest.importorskip('cv2', reason='needs OpenCV, an extra: film')
pytest.importorskip('av', reason='needs PyAV, an extra: film')

import cv2
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
import numpy as np
from rendered_camera import painter_of
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header
from vision_msgs.msg import Detection3DArray
from waiting import PatientCaller, spin_until

from billiard_shot import Scene
from billiard_shot.ros.table_camera import decoded, ENCODINGS, picture_from, rectification

SCENE = Scene.load('robot_table')
COLOURS = np.kron(
    np.array([[[200, 40, 30], [30, 60, 210]]], np.uint8), np.ones((8, 8, 1), np.uint8)
)


def encoded(picture, encoding):
    """Bytes of a picture in an encoding of ROS, by OpenCV or, for a mosaic, by its definition."""
    height, width = picture.shape[:2]
    if encoding.startswith('bayer'):
        mosaic = np.empty((height, width, 1), np.uint8)
        for k, channel in enumerate(encoding[6:10]):
            part = slice(k // 2, None, 2), slice(k % 2, None, 2)
            mosaic[(*part, 0)] = picture[(*part, 'rgb'.index(channel))]
        return mosaic
    if encoding.startswith('yuv'):
        yuy2 = encoding.endswith('yuy2')
        code = cv2.COLOR_RGB2YUV_YUY2 if yuy2 else cv2.COLOR_RGB2YUV_UYVY
        return cv2.cvtColor(picture, code)
    order = ['rgba'.index(channel) for channel in encoding[:-1]]
    return np.concatenate([picture, np.full((height, width, 1), 255, np.uint8)], -1)[..., order]


@pytest.mark.parametrize('encoding', ENCODINGS)
def test_pictures_of_all_encodings_are_alike(encoding):
    """Rows may be longer than their pixels."""
    rows = encoded(COLOURS, encoding).reshape(8, -1)
    padded = np.pad(rows, ((0, 0), (0, 5)))
    message = Image(height=8, width=16, step=padded.shape[1], encoding=encoding)
    message.data = padded.tobytes()
    seen = picture_from(message)
    inside = (slice(2, 6), [3, 4, 11, 12])
    np.testing.assert_allclose(seen[inside].astype(int), COLOURS[inside], atol=20)


@pytest.mark.parametrize(
    ('fields', 'words'),
    [
        ({'encoding': 'mono8'}, 'encoding must be one of rgb8'),
        ({'step': 3}, 'step at least 48 bytes'),
        ({'height': 9}, '9 x 48'),
        ({'width': 0}, 'data must have'),
    ],
)
def test_pictures_that_are_not_valid_are_named(fields, words):
    message = Image(height=8, width=16, step=48, encoding='rgb8', data=COLOURS.tobytes())
    for name, value in fields.items():
        setattr(message, name, value)
    with pytest.raises(ValueError, match=words):
        picture_from(message)
    with pytest.raises(ValueError, match='JPEG'):
        decoded(CompressedImage(format='jpeg', data=b'no picture'))


def test_the_picture_of_a_calibrated_camera_is_that_of_a_pinhole():
    matrix = np.array([[300.0, 0, 170], [0, 310, 115], [0, 0, 1]])
    terms = [-0.2, 0.05, 1e-3, -1e-3, 0.0]
    info = CameraInfo(width=320, height=240, distortion_model='plumb_bob', k=matrix.ravel())
    assert rectification(CameraInfo()) is None
    info.d = terms
    ray = np.array([[0.3, -0.2, 1.0]])
    none = np.zeros(3)
    ((at,),) = cv2.projectPoints(ray, none, none, matrix, np.array(terms))[0]
    picture = np.zeros((240, 320, 3), np.uint8)
    v, u = np.mgrid[:240, :320]
    spot = 255 * np.exp(-((u - at[0]) ** 2 + (v - at[1]) ** 2) / 8.0)
    picture[:] = spot[..., np.newaxis].astype(np.uint8)
    seen = rectification(info)(picture)[..., 0].astype(float)
    centre = np.array([(seen * u).sum(), (seen * v).sum()]) / seen.sum()
    np.testing.assert_allclose(centre, 300.0 * ray[0, :2] + (159.5, 119.5), atol=0.1)


def test_balls_are_detected_and_a_camera_that_moves_is_noticed(node, launch_once):
    """Compressed pictures; the node is started by hand."""
    space = '/camera'
    launch_once('table_camera', '-r', f'__ns:={space}', '-p', 'autostart:=false')
    heard, health = [], []
    node.create_subscription(Detection3DArray, f'{space}/detections', heard.append, 10)
    node.create_subscription(DiagnosticArray, '/diagnostics', health.append, 10)
    images = node.create_publisher(CompressedImage, f'{space}/image/compressed', 1)
    painter = painter_of(SCENE)
    painter.motion.put({'cue': (0.3, -0.2), '8': (-0.6, 0.1), '3': (0.9, 0.3)})
    still = painter.at(0.0)
    moved = cv2.warpAffine(still, np.float64([[1, 0, 5.0], [0, 1, 2.0]]), (640, 360))
    shown = [still]

    def see():
        code = cv2.imencode('.png', cv2.cvtColor(shown[0], cv2.COLOR_RGB2BGR))[1]
        header = Header(stamp=node.get_clock().now().to_msg())
        images.publish(CompressedImage(header=header, format='png', data=code.tobytes()))

    timer = node.create_timer(0.1, see)

    def says(words):
        health.clear()
        return spin_until(node, lambda: any(words in each.status[0].message for each in health))

    change = PatientCaller(node, ChangeState, f'{space}/table_camera/change_state')
    assert change.wait_for_service()
    assert says('no picture received')

    def go(transition):
        request = ChangeState.Request()
        request.transition.id = transition
        return change.call(request).success

    assert go(Transition.TRANSITION_CONFIGURE)
    assert go(Transition.TRANSITION_ACTIVATE)
    assert spin_until(node, lambda: heard and len(heard[-1].detections) == 3)
    assert says('sees the table')
    assert heard[-1].header.frame_id == 'table'
    for each in heard[-1].detections:
        (result,) = each.results
        x, y, _ = painter.motion.places[result.hypothesis.class_id]
        place, sigma = result.pose.pose.position, np.sqrt(result.pose.covariance[0])
        assert np.hypot(place.x - x, place.y - y) < 4e-3
        assert 1e-4 < sigma < 2e-3
        assert result.hypothesis.score > 0.5
    shown[0] = moved
    assert says('the camera moved by')
    heard.clear()
    assert says('sees the table'), 'the table is not found again'
    assert spin_until(node, lambda: heard and len(heard[-1].detections) == 3)
    assert go(Transition.TRANSITION_ACTIVE_SHUTDOWN)
    assert says('the node is not active')
    timer.cancel()
