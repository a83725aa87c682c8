"""The node `table_camera`: detects the balls in the pictures of a camera above the table."""

from array import array
from collections.abc import Sequence
from dataclasses import dataclass
import sys
from time import monotonic, process_time
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import Point, Vector3
import numpy as np
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from billiard_shot.perception.gate import check_name
from billiard_shot.ros import parameters
from billiard_shot.ros.conversions import filled, picture_time
from billiard_shot.ros.node_runner import in_thread, spin_node, steady_timer
from billiard_shot.ros.parameters import checked, OfTable
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import must_be
from billiard_shot.scene.placement import CUE_BALL

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
"""QoS of pictures: a picture that waits is replaced by the next one."""

FIRST, FIRST_PERIOD = 8, 0.2
"""Pictures in which the table is sought, and the time between two of them [s]."""

MOVED, CHECK_PERIOD, MOST_MOVED = 0.6, 0.5, 4
"""
Motion of the camera that withholds detections [px], the time between two looks for it [s], and the
number of successive looks after which the table is sought again.
"""

LOG_PERIOD = 5.0
"""Shortest time between two warnings [s]."""

SILENCE = 1.0
"""Time without a picture after which diagnostics say so [s]."""


def corners_of(values: Sequence[float]) -> Any:
    """Corners (4, 2) [px] from eight numbers; None from [0.0]."""
    if list(values) == [0.0]:
        return None
    if len(values) != 8 or not np.isfinite(values).all():
        raise ValueError(f'corners {must_be("u and v of four corners, or [0.0]", list(values))}')
    return np.reshape(values, (4, 2)).astype(float)


def _check_balls(names: Sequence[str]) -> None:
    for name in names:
        check_name('balls', name)


@dataclass(frozen=True)
class TableCameraParameters(OfTable):
    """
    Parameters of the node.

    Parameters
    ----------
    scene : str
        Table, and radius of the balls: name of a bundled scene, or path of a YAML file.
    balls : list of str
        Names of the balls that may be on the table: numbers of pool balls, and names that begin
        with a colour. A spot whose colour is that of no ball is not a ball.
    corners : list of float
        Pixels u, v of the four corners at which the lines of the noses cross; [0.0]: they are
        found.
    turned : bool
        Whether the x axis of the table points to the left in the picture, instead of to the right.
    autostart : bool
        Configure and activate the node at start-up.

    """

    READ_ONLY: ClassVar = ('autostart',)
    scene: str = checked('pool_table', Scene.load)
    balls: list[str] = checked([CUE_BALL, *map(str, range(1, 16))], _check_balls)
    corners: list[float] = checked([0.0], corners_of)
    turned: bool = False
    autostart: bool = True


class TableCamera(LifecycleNode):
    """
    Lifecycle node that publishes `detections` (vision_msgs/msg/Detection3DArray) of balls.

    Subscribes to `image` (sensor_msgs/msg/Image), `image/compressed` (CompressedImage) and
    `camera_info` (CameraInfo). If a camera is calibrated, its pictures are rectified first. The
    first pictures after the activation tell the table of the scene; the detections are in its
    frame, with the stamp of the picture, and with covariances. The class of a detection is the
    name of a ball, and its score tells how like the colours are. If the camera moves, or something
    hides all that shows its motion, no detections are published, and after some time the table is
    sought again. `~/outlines` (Image) shows noses and balls if somebody subscribes, and
    `/diagnostics` tells rate, processor time and problems. Its parameters are
    `TableCameraParameters`; they are read by `configure`.
    """

    def __init__(self, messages: Any) -> None:
        super().__init__('table_camera')
        parameters.declare(self, TableCameraParameters)
        self._messages = messages  # the module vision_msgs.msg
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._detections = self.create_publisher(messages.Detection3DArray, 'detections', 10)
        self._outlines = self.create_publisher(Image, '~/outlines', 1)
        for kind, topic, read in (
            (Image, 'image', picture_from),
            (CompressedImage, 'image/compressed', decoded),
        ):
            self.create_subscription(
                kind, topic, lambda message, read=read: self._on_image(message, read), NEWEST
            )
        self.create_subscription(CameraInfo, 'camera_info', self._on_info, NEWEST)
        self._info, self._rectify = CameraInfo(), None
        self._is_active = False
        self._reset('no picture received')
        steady_timer(self, 1.0, self._publish_diagnostics)
        starts = parameters.values_of(TableCameraParameters, self).autostart
        if starts and self.trigger_configure() is TransitionCallbackReturn.SUCCESS:
            self.trigger_activate()

    def _reset(self, problem: str) -> None:
        """Forget the table; it is sought in the next pictures."""
        self._watched: Any = None
        self._first: list[Any] = []
        self._problem, self._last, self._looked, self._moved = problem, -np.inf, -np.inf, 0
        self._done: list[tuple[float, float]] = []  # ends and processor times of pictures [s]

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the parameters."""
        self._own = parameters.values_of(TableCameraParameters, self)
        self._scene = Scene.load(self._own.scene)
        if self._scene.table is None:
            self.get_logger().error(f'scene must have a table, got {self._own.scene!r}')
            return TransitionCallbackReturn.FAILURE
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Seek the table, then balls."""
        self._reset('no picture received')
        self._is_active = True
        self.get_logger().info('ready: seeks a table in pictures')
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Ignore pictures."""
        self._is_active = False
        self._reset('the node is not active')
        return super().on_deactivate(state)

    on_shutdown = on_deactivate

    def _on_info(self, info: CameraInfo) -> None:
        """Rectify pictures from now on, if the camera is calibrated."""
        if (list(info.k), list(info.d)) == (list(self._info.k), list(self._info.d)):
            return
        self._info, self._rectify = info, rectification(info)
        self._reset('the calibration of the camera is new')

    def _on_image(self, message: Any, read: Any) -> None:
        if not self._is_active:
            return
        begin, now = process_time(), 1e-9 * self.get_clock().now().nanoseconds
        try:
            time = picture_time(message.header.stamp, now) or now
            picture = read(message)
        except ValueError as error:
            self._warn(f'ignored a picture: {error}')
            return
        if not time > self._last:
            return
        self._last = time
        if self._rectify is not None:
            picture = self._rectify(picture)
        if self._watched is None:
            self._seek(picture)
        elif self._is_still(picture):
            self._see(picture, time, message.header)
            self._done = [*self._done[-99:], (monotonic(), process_time() - begin)]

    def _seek(self, picture: Any) -> None:
        """Seek the table in some pictures, in a thread."""
        from billiard_shot.film.watched_table import WatchedTable

        first, own, scene = self._first, self._own, self._scene
        if first and first[0].shape != picture.shape:
            first.clear()
        if len(first) == FIRST or monotonic() - self._looked < FIRST_PERIOD:
            return
        self._looked = monotonic()
        first.append(picture)
        if len(first) == FIRST:
            corners = corners_of(own.corners)
            search = in_thread(
                self, lambda: WatchedTable(first, scene, own.balls, corners, own.turned)
            )
            search.add_done_callback(lambda ended: self._end_search(ended, first))

    def _end_search(self, ended: Any, first: list[Any]) -> None:
        if first is not self._first:
            return  # the node has been reset meanwhile
        if error := ended.exception():
            self._reset(f'no table: {error}')
            self._warn(self._problem)
            return
        self._watched, self._problem = ended.result(), ''
        self.get_logger().info(f'found the table: {self._watched.table.note}')

    def _is_still(self, picture: Any) -> bool:
        """Whether the camera stands where it found the table."""
        if picture.shape[1::-1] != self._watched.camera.size:
            self._reset('the size of the pictures is new')
            return False
        if monotonic() - self._looked > CHECK_PERIOD:
            self._looked = monotonic()
            move = self._watched.move(picture)
            self._moved = self._moved + 1 if move > MOVED else 0
            self._problem = f'the camera moved by {move:.1f} px' if self._moved else ''
            if self._moved >= MOST_MOVED:
                self._warn(f'{self._problem}: seeks the table again')
                self._reset(self._problem)
        return not self._moved and self._watched is not None

    def _see(self, picture: Any, time: float, header: Header) -> None:
        """Publish the balls of a picture."""
        balls = self._watched.balls(picture, time)
        own = parameters.table_header(self, header.stamp)
        message = self._messages.Detection3DArray(header=own)
        radius = self._scene.ball.radius
        for ball in balls:
            result = self._messages.ObjectHypothesisWithPose()
            result.hypothesis.class_id, result.hypothesis.score = ball.name, ball.likeness
            result.pose.pose.position = filled(Point, (*ball.place, radius))
            result.pose.covariance = (ball.sigma**2 * np.diag([1.0, 1, 1, 0, 0, 0])).ravel()
            detection = self._messages.Detection3D(header=own, results=[result])
            detection.bbox.center = result.pose.pose
            detection.bbox.size = filled(Vector3, (2.0 * radius,) * 3)
            message.detections.append(detection)
        self._detections.publish(message)
        if self._outlines.get_subscription_count():
            self._outlines.publish(image_message(self._watched.outlined(picture, balls), header))

    def _warn(self, words: str) -> None:
        self.get_logger().warning(words, throttle_duration_sec=LOG_PERIOD)

    def _publish_diagnostics(self) -> None:
        recent = [spent for end, spent in self._done if monotonic() - end < SILENCE]
        problem = self._problem or ('' if recent else f'no picture for {SILENCE:g} s')
        values = {'pictures a second': len(recent) / SILENCE}
        if recent:
            values['processor time of a picture [ms]'] = 1e3 * float(np.median(recent))
        if self._watched:
            values['errors of noses and sights [px]'] = self._watched.table.error
        name = self.get_fully_qualified_name()
        status = DiagnosticStatus(
            level=DiagnosticStatus.WARN if problem else DiagnosticStatus.OK,
            name=name,
            hardware_id=f'{name.rpartition("/")[0]}/camera',
            message=problem or 'sees the table',
            values=[KeyValue(key=key, value=f'{value:.3g}') for key, value in values.items()],
        )
        stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(DiagnosticArray(header=Header(stamp=stamp), status=[status]))


# --- pictures -----------------------------------------------------------------------------------

ENCODINGS = {
    'rgb8': (3, ''),
    'bgr8': (3, 'BGR2RGB'),
    'rgba8': (4, 'RGBA2RGB'),
    'bgra8': (4, 'BGRA2RGB'),
    'yuv422': (2, 'YUV2RGB_UYVY'),
    'yuv422_yuy2': (2, 'YUV2RGB_YUY2'),
    **{
        f'bayer_{each}8': (1, f'Bayer{each.upper()}2RGB')
        for each in ('rggb', 'bggr', 'gbrg', 'grbg')
    },
}
"""Of sensor_msgs/image_encodings.hpp: bytes of a pixel, and the conversion of OpenCV."""


def picture_from(message: Image) -> Any:
    """Picture (height, width, 3), RGB, of a message; ValueError for one that is not valid."""
    import cv2

    if message.encoding not in ENCODINGS:
        raise ValueError(f'encoding {must_be("one of " + ", ".join(ENCODINGS), message.encoding)}')
    count, code = ENCODINGS[message.encoding]
    data, width = np.frombuffer(message.data, np.uint8), message.width * count
    if not (message.step >= width > 0 and 0 < message.height * message.step <= len(data)):
        raise ValueError(
            f'data must have height x step bytes, {message.height} x {message.step}, and step at '
            f'least {width} bytes, got {len(data)}'
        )
    rows = data[: message.height * message.step].reshape(message.height, message.step)[:, :width]
    picture = np.ascontiguousarray(rows).reshape(message.height, message.width, count)
    return cv2.cvtColor(picture, getattr(cv2, f'COLOR_{code}')) if code else picture


def decoded(message: CompressedImage) -> Any:
    """Picture (height, width, 3), RGB, of a message; ValueError for one that is not valid."""
    import cv2

    data = np.frombuffer(message.data, np.uint8)
    picture = cv2.imdecode(data, cv2.IMREAD_COLOR) if len(data) else None
    if picture is None:
        raise ValueError(f'data {must_be("a JPEG or PNG picture", message.format)}')
    return cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)


def image_message(picture: Any, header: Header) -> Image:
    """Message of a picture (height, width, 3), RGB."""
    height, width = picture.shape[:2]
    return Image(
        header=header, height=height, width=width, encoding='rgb8', step=3 * width,
        data=array('B', picture.tobytes()),
    )  # fmt: skip


def rectification(info: CameraInfo) -> Any:
    """
    Return what makes pictures of a calibrated camera those of a pinhole; None if it is not.

    The pinhole has the focal length of the rows of pixels, and its axis is in the middle.
    """
    import cv2

    matrix, size = np.reshape(info.k, (3, 3)), (info.width, info.height)
    if not (matrix[0, 0] > 0.0 and matrix[1, 1] > 0.0 and min(size) > 0):
        return None
    pinhole = np.diag([matrix[0, 0], matrix[0, 0], 1.0])
    pinhole[:2, 2] = 0.5 * (np.array(size) - 1.0)
    is_fisheye = info.distortion_model == 'equidistant'
    library: Any = cv2.fisheye if is_fisheye else cv2
    terms = np.array(info.d) if len(info.d) else np.zeros(4)
    first, second = library.initUndistortRectifyMap(
        matrix, terms, np.eye(3), pinhole, size, cv2.CV_16SC2
    )
    return lambda picture: cv2.remap(picture, first, second, cv2.INTER_LINEAR)


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    try:
        import cv2  # noqa: F401
        from vision_msgs import msg
    except ImportError as error:
        sys.exit(
            f'table_camera: {error}; install ros-*-vision-msgs and python3-opencv, or '
            "pip install 'billiard_shot[film]'"
        )
    spin_node(lambda: TableCamera(msg), 'table_camera', args)
