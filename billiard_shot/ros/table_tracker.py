"""
The node `table_tracker`: estimates where the balls lie from the detections of a camera.

Detections come in the messages of cameras; positions may be relative to other frames.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
import math
import re
import sys
from time import monotonic
from typing import Any, ClassVar

from billiard_shot_msgs.msg import BallState, TableState
from geometry_msgs.msg import TransformStamped
import numpy as np
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, qos_profile_sensor_data, QoSProfile
from rclpy.serialization import deserialize_message
from std_srvs.srv import Trigger

from billiard_shot.impact.collide import rotation_matrix
from billiard_shot.perception import gate
from billiard_shot.perception.gate import MAX_DEVIATION
from billiard_shot.perception.tracker import BallTracker, Detection, TrackerSettings
from billiard_shot.records import Array
from billiard_shot.ros import parameters
from billiard_shot.ros.conversions import ball_message, picture_time, seconds, stamp_of, xyz, xyzw
from billiard_shot.ros.node_runner import LATCHED, spin_node, steady_timer
from billiard_shot.ros.parameters import checked, OfTable
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import must_be
from billiard_shot.scene.fields import number
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.run.outline import outline_of

MAX_APART = 0.1
"""Longest time between a transform that changes and the position that it transforms [s]."""

STATIC = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""QoS of `/tf_static`, whose publishers are latched."""


class Frames:
    """
    The latest transforms between frames.

    tf2_ros is not used, because PyPI does not have it. It interpolates transforms; a camera that
    moves needs transforms at its rate here.

    Parameters
    ----------
    node : Node
        Node that listens. Without the package tf2_msgs it hears nothing.

    """

    def __init__(self, node: Node) -> None:
        self._latest: dict[str, tuple[TransformStamped, bool]] = {}  # by child; whether static
        self.missing = ''
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            self.missing = 'the package tf2_msgs is missing'
            return
        node.create_subscription(TFMessage, '/tf', lambda message: self.hear(message, False), 100)
        node.create_subscription(
            TFMessage, '/tf_static', lambda message: self.hear(message, True), STATIC
        )

    def hear(self, message: Any, is_static: bool) -> None:
        """Take transforms (tf2_msgs/msg/TFMessage)."""
        for each in message.transforms:
            self._latest[each.child_frame_id] = each, is_static

    def between(self, frame: str, root: str, time: float) -> tuple[Array, Array]:
        """
        Rotation (3, 3) and translation (3,) [m] from a frame to another one.

        Parameters
        ----------
        frame, root : str
            A point p in `frame` is at R p + t in `root`.
        time : float
            Time of the point [s]; 0 if it has none.

        Raises
        ------
        ValueError
            If the frames are not connected, if the quaternion of a transform does not have the
            length 1, or if a transform that changes is too old or too new.

        """
        up, down = self._to_top(frame, time), self._to_top(root, time)
        if up[0] != down[0]:
            why = self.missing or f'no transform connects {up[0]!r} and {down[0]!r}'
            raise ValueError(f'frame {frame!r} is not known in {root!r}: {why}')
        (_, r, t), (_, r0, t0) = up, down
        return r0.T @ r, r0.T @ (t - t0)

    def _to_top(self, frame: str, time: float) -> tuple[str, Array, Array]:
        """Topmost frame above a frame, and the rotation and translation to it."""
        rotation, translation = np.eye(3), np.zeros(3)
        passed = {frame}
        while frame in self._latest:
            step, is_static = self._latest[frame]
            apart = abs(seconds(step.header.stamp) - time)
            if not is_static and time and apart > MAX_APART:
                raise ValueError(
                    f'the transform of {frame!r} must be within {MAX_APART:g} s of the position, '
                    f'got {apart:.3g} s'
                )
            turn = xyzw(step.transform.rotation)
            gate.check_quaternion(f'the rotation of the transform of {frame!r}', turn)
            r = rotation_matrix(np.array(turn) / math.hypot(*turn))
            rotation, translation = r @ rotation, r @ translation + xyz(step.transform.translation)
            frame = step.header.frame_id
            if frame in passed:
                raise ValueError(f'the transforms of {frame!r} form a circle')
            passed.add(frame)
        return frame, rotation, translation


CLASS = re.compile(r'(?:(?P<class_id>[^=*]+)=)?(?P<name>[^=*]+)(?:\*(?P<count>[1-9]\d?))?')
"""A class of detections: its id, if that is not the name of the ball, and the number of balls."""


def class_names_of(entries: Sequence[str]) -> dict[str, str]:
    """Names of balls by class id, from entries such as `8`, `white=cue` and `solid*7`."""
    names = {}
    for entry in entries:
        found = CLASS.fullmatch(entry)
        most = 1 if found and found['name'] == CUE_BALL else gate.MAX_BALLS
        if not found or int(found['count'] or 1) > most:
            allowed = f"such as '8', 'white=cue' or 'solid*7', with at most {most} balls"
            raise ValueError(f'class_names {must_be(allowed, entry)}')
        names[found['class_id'] or found['name']] = found['name']
        gate.check_name('class_names', f'{found["name"]}_{gate.MAX_BALLS}')  # the longest name
    return names


def class_counts_of(entries: Sequence[str], balls: Iterable[str]) -> dict[str, int]:
    """
    Numbers of balls of classes with more than one, by name.

    A number that is not stated is that of the `balls` of a scene, named `solid`, `solid_2`, ...
    """
    counts = Counter(re.sub(r'_\d+$', '', name) for name in balls)
    for found in filter(None, map(CLASS.fullmatch, entries)):
        if found['count']:
            counts[found['name']] = int(found['count'])
    return counts | Counter([CUE_BALL])


def detected_balls(
    detections: Sequence[Any],
    names: Mapping[str, str],
    min_score: float,
    usual_variance: float,
    rotation: Array,
    translation: Array,
) -> tuple[list[Detection], list[str]]:
    """
    Balls of a picture in the frame of the table, and why each other detection is ignored.

    Detections of classes that have no name in `names`, which are by class id, are ignored, and so
    are those that do not pass the gate. If a detection has no covariance, x and y have the
    `usual_variance` [m^2]. More balls than a table can have raise ValueError.
    """
    found, ignored = [], []
    for each in detections:
        best = max(each.results, key=lambda result: result.hypothesis.score, default=None)
        if best is None or not best.hypothesis.score >= min_score:
            continue
        if best.hypothesis.class_id in names:
            found.append((each, best))
        else:
            ignored.append(f'class_id {must_be("in class_names", best.hypothesis.class_id)}')
    gate.check_count('detections of balls', found)
    balls = []
    for each, best in found:
        name, centre = names[best.hypothesis.class_id], best.pose.pose.position
        noise = best.pose.covariance.reshape(6, 6)
        if not noise.any() and xyz(centre) == (0.0, 0.0, 0.0):
            centre = each.bbox.center.position
        with np.errstate(all='ignore'):  # the gate refuses numbers that are not finite
            place = (rotation @ xyz(centre) + translation).tolist()
            turned = (rotation @ noise[:3, :3] @ rotation.T).ravel().tolist()
        try:
            gate.check_position(f'position of {name!r}', place)
            xx, xy, yy = gate.plane_covariance(f'covariance of {name!r}', turned)
        except ValueError as error:
            ignored.append(str(error))
            continue
        if not xx * yy > xy * xy:
            xx, xy, yy = usual_variance, 0.0, usual_variance
        balls.append(Detection(name, (place[0], place[1]), (xx, xy, yy)))
    return balls, ignored


REPEAT_PERIOD = 0.2
"""Time after which table_state is repeated if there are no pictures [s]."""

MAX_BYTES = 2**19
"""Largest size of a message of detections: some 1,000 detections; to read it takes 0.1 s."""

IGNORED_PERIOD = 60.0
"""Time between two reports of the detections that were ignored [s]."""

LOG_PERIOD = 5.0
"""Shortest time between two warnings about ignored pictures, or about too many balls [s]."""


@dataclass(frozen=True)
class TableTrackerParameters(OfTable):
    """
    Parameters of the node.

    Parameters
    ----------
    scene : str
        Radius of the balls, and pockets: name of a bundled scene, or path of a YAML file.
    class_names : list of str
        Class ids of the detections that are balls: names of balls such as `8`, pairs such as
        `white=cue` for other class ids, and numbers of balls such as `solid*7`, otherwise as many
        as the scene has, at least one. Names of balls of the scene need not be listed. Detections
        of all other classes are ignored.
    detection_noise : float
        Standard deviation of a detected position, in each direction, if the detection has no
        covariance [m].
    min_score : float
        Smallest score of a detection that is used.

    """

    READ_ONLY: ClassVar = ('scene', 'class_names', 'detection_noise', 'min_score')
    scene: str = checked('paper', Scene.load)
    class_names: list[str] = checked([CUE_BALL, *map(str, range(1, 16))], class_names_of)
    detection_noise: float = number('m', minimum=1e-6, maximum=MAX_DEVIATION, default=0.0005)
    min_score: float = number('', minimum=0.0, maximum=1.0, default=0.5)


class TableTracker(Node):
    """
    Node that publishes `table_state` (billiard_shot_msgs/msg/TableState), latched.

    Subscribes to `detections` (vision_msgs/msg/Detection3DArray) in any frame that tf2 connects to
    the frame of the table. Of each detection it uses the hypothesis with the highest score. If its
    pose is empty, the centre of the bounding box is the position of the ball. Heights are not
    used. The covariance of the pose is that of one detection.

    Detections that are not balls, by their class or by the checks of sightings, are
    ignored; the log has their number. A message with more balls than a table can have, or with
    a stamp ahead of the clock, is ignored as a whole. All other messages are pictures, also those
    without detections.

    `table_state` is published after every picture, and repeated if there is none, with the stamp
    of the last picture. The service `~/reset` (std_srvs/srv/Trigger) forgets all balls. Its
    parameters are `TableTrackerParameters` and `TrackerSettings`.
    """

    def __init__(self, detections_type: type) -> None:
        super().__init__('table_tracker')
        parameters.declare(self, TableTrackerParameters, TrackerSettings)
        own = parameters.values_of(TableTrackerParameters, self)
        scene = Scene.load(own.scene)
        names = {name: name for name in (CUE_BALL, *scene.balls)}
        names |= class_names_of(own.class_names)
        self._reading = names, own.min_score, own.detection_noise**2
        self._detections_type = detections_type
        self._ignored: Counter[str] = Counter()  # by reason, since the log had them
        self._told = -math.inf  # when that was [s]
        self._tracker = BallTracker(
            scene.ball.radius,
            parameters.values_of(TrackerSettings, self),
            outline_of(scene).holes if scene.table else (),
            class_counts_of(own.class_names, scene.balls),
        )
        self._frames = Frames(self)
        self._snapshot, self._published = 0, ''
        self._publisher = self.create_publisher(TableState, 'table_state', LATCHED)
        self.create_subscription(
            detections_type, 'detections', self._on_detections, qos_profile_sensor_data, raw=True
        )
        self.create_service(Trigger, '~/reset', self._reset)
        self._repeat = steady_timer(self, REPEAT_PERIOD, self._publish)
        self.get_logger().info('ready: tracks balls')

    def _on_detections(self, raw: bytes) -> None:
        now = 1e-9 * self.get_clock().now().nanoseconds
        root = self.get_parameter('frame').value
        try:
            if len(raw) > MAX_BYTES:
                raise ValueError(f'detections must have at most {MAX_BYTES} bytes, got {len(raw)}')
            message: Any = deserialize_message(raw, self._detections_type)
            time = picture_time(message.header.stamp, now) or now
            transform = self._frames.between(message.header.frame_id or root, root, time)
            balls, ignored = detected_balls(message.detections, *self._reading, *transform)
        except ValueError as error:
            self.get_logger().warning(
                f'ignored a picture: {error}', throttle_duration_sec=LOG_PERIOD
            )
            return
        self._ignored.update(ignored)
        if self._ignored and monotonic() - self._told > IGNORED_PERIOD:
            reasons = (f'{why} ({times} times)' for why, times in self._ignored.most_common(20))
            self.get_logger().info(
                f'ignored {self._ignored.total()} detections: {"; ".join(reasons)}'
            )
            self._ignored, self._told = Counter(), monotonic()
        self._tracker.update(balls, time)
        if surplus := self._tracker.surplus:
            self.get_logger().warning(
                f'more balls than class_names allows are seen and left out: {", ".join(surplus)}',
                throttle_duration_sec=LOG_PERIOD,
            )
        self._repeat.reset()
        self._publish()

    def _publish(self) -> None:
        """Publish the balls; the stamp is that of the last picture."""
        now = 1e-9 * self.get_clock().now().nanoseconds
        balls = [
            *(ball_message(name, ball) for name, ball in self._tracker.balls(now).items()),
            *(BallState(id=name, state=BallState.POCKETED) for name in self._tracker.pocketed),
        ]
        if (content := repr(balls)) != self._published:
            self._snapshot, self._published = self._snapshot + 1, content
        header = parameters.table_header(self, stamp_of(self._tracker.time))
        self._publisher.publish(TableState(header=header, snapshot_id=self._snapshot, balls=balls))

    def _reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._tracker.reset()
        response.success, response.message = True, 'all balls are forgotten'
        return response


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    try:
        from vision_msgs.msg import Detection3DArray
    except ImportError:
        sys.exit('table_tracker: the package vision_msgs is missing; install ros-*-vision-msgs')
    spin_node(lambda: TableTracker(Detection3DArray), 'table_tracker', args)
