"""The node `table_tracker`: estimates where the balls lie from the detections of a camera."""

# ruff: noqa: RUF009 (the calls in class bodies make fields, as dataclasses.field does)
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
import math
import sys
from typing import Any, ClassVar

from billiard_shot_msgs.msg import BallState, TableState
import numpy as np
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from std_srvs.srv import Trigger

from billiard_shot.perception.tracker import BallTracker, Detection, TrackerSettings
from billiard_shot.records import Array
from billiard_shot.ros import parameters
from billiard_shot.ros.conversions import ball_message, seconds, time_of
from billiard_shot.ros.frames import FrameError, Frames
from billiard_shot.ros.node_runner import LATCHED, spin_node, steady_timer
from billiard_shot.ros.parameters import check_scene, checked, OfTable
from billiard_shot.scene import Scene
from billiard_shot.scene.fields import number
from billiard_shot.table.outline import outline_of

REPEAT_PERIOD = 0.2
"""Time after which table_state is repeated if there are no detections [s]."""


def class_names_of(pairs: list[str]) -> dict[str, str]:
    """
    Names of balls by class id, from pairs such as `white=cue`.

    Raises
    ------
    ValueError
        If a pair has no equals sign, or an empty side.

    """
    names = {}
    for pair in pairs:
        class_id, sign, name = pair.partition('=')
        if not (class_id and sign and name):
            raise ValueError(f"class_names must be pairs such as 'white=cue', got {pair!r}")
        names[class_id] = name
    return names


@dataclass(frozen=True)
class TableTrackerParameters(OfTable):
    """
    Parameters of the node.

    Parameters
    ----------
    scene : str
        Radius of the balls, and pockets: name of a bundled scene, or path of a YAML file.
    class_names : list of str
        Names of balls by the class ids of the detections, as pairs such as `white=cue`. Every
        other class id is the name of a ball itself.
    detection_noise : float
        Standard deviation of a detected position, in each direction, if the detection has no
        covariance [m].
    min_score : float
        Smallest score of a detection that is used.

    """

    READ_ONLY: ClassVar = ('scene', 'class_names', 'detection_noise', 'min_score')
    scene: str = checked('paper', check_scene)
    class_names: list[str] = checked(['cue=cue'], class_names_of)
    detection_noise: float = number('m', minimum=1e-6, maximum=0.1, default=0.0005)
    min_score: float = number('', minimum=0.0, maximum=1.0, default=0.5)


class TableTracker(Node):
    """
    Node that publishes `table_state` (billiard_shot_msgs/msg/TableState), latched.

    Subscribes to `detections` (vision_msgs/msg/Detection3DArray) in any frame that tf2 connects to
    the frame of the table. Of each detection it uses the hypothesis with the highest score. If its
    pose is empty, the centre of the bounding box is the position of the ball. Heights are not
    used. The covariance of the pose is that of one detection.

    `table_state` is published after every message, and repeated if there is none, with the stamp
    of the last detection. The service `~/reset` (std_srvs/srv/Trigger) forgets all balls. Its
    parameters are `TableTrackerParameters` and `TrackerSettings`.
    """

    def __init__(self, detections_type: type) -> None:
        super().__init__('table_tracker')
        parameters.declare(self, TableTrackerParameters, TrackerSettings)
        own = parameters.read(TableTrackerParameters, self)
        scene = Scene.load(own.scene)
        self._names = class_names_of(own.class_names)
        self._variance, self._min_score = own.detection_noise**2, own.min_score
        self._tracker = BallTracker(
            scene.ball.radius,
            parameters.read(TrackerSettings, self),
            outline_of(scene).holes if scene.table else (),
        )
        self._frames = Frames(self)
        self._snapshot, self._published = 0, ''
        self._publisher = self.create_publisher(TableState, 'table_state', LATCHED)
        self.create_subscription(
            detections_type, 'detections', self._on_detections, qos_profile_sensor_data
        )
        self.create_service(Trigger, '~/reset', self._reset)
        self._repeat = steady_timer(self, REPEAT_PERIOD, self._publish)
        self.get_logger().info('ready: tracks balls')

    def _on_detections(self, message: Any) -> None:
        now = 1e-9 * self.get_clock().now().nanoseconds
        time = seconds(message.header.stamp) or now
        root = self.get_parameter('frame').value
        try:
            transform = self._frames.between(message.header.frame_id or root, root, time)
        except FrameError as error:
            self.get_logger().warning(f'ignored detections: {error}', throttle_duration_sec=5.0)
            return
        self._tracker.update(list(self._detections(message.detections, *transform)), time)
        self._repeat.reset()
        self._publish()

    def _detections(
        self, detections: Iterable[Any], rotation: Array, translation: Array
    ) -> Iterable[Detection]:
        """Balls that are detected surely enough, in the frame of the table."""
        for each in detections:
            best = max(each.results, key=lambda result: result.hypothesis.score, default=None)
            if best is None or not best.hypothesis.score >= self._min_score:
                continue
            centre, noise = best.pose.pose.position, np.array(best.pose.covariance).reshape(6, 6)
            if not noise.any() and (centre.x, centre.y, centre.z) == (0.0, 0.0, 0.0):
                centre = each.bbox.center.position
            x, y, _ = (rotation @ (centre.x, centre.y, centre.z) + translation).tolist()
            turned = rotation @ noise[:3, :3] @ rotation.T
            xx, xy, yy = turned[0, 0], turned[0, 1], turned[1, 1]
            if not xx * yy > xy * xy:
                xx, xy, yy = self._variance, 0.0, self._variance
            if all(map(math.isfinite, (x, y, xx, xy, yy))):
                name = self._names.get(best.hypothesis.class_id, best.hypothesis.class_id)
                yield Detection(name, (x, y), (float(xx), float(xy), float(yy)))

    def _publish(self) -> None:
        """Publish the balls; the stamp is that of the last detection."""
        now = 1e-9 * self.get_clock().now().nanoseconds
        balls = [
            *(ball_message(name, ball) for name, ball in self._tracker.balls(now).items()),
            *(BallState(id=name, state=BallState.POCKETED) for name in self._tracker.pocketed),
        ]
        if (content := repr(balls)) != self._published:
            self._snapshot, self._published = self._snapshot + 1, content
        header = parameters.table_header(self, time_of(self._tracker.time))
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


if __name__ == '__main__':
    main()
