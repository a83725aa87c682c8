"""The node `table_tracker`: estimates where the balls lie from the detections of a camera."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
import math
import sys
from time import monotonic
from typing import Any, ClassVar

from billiard_shot_msgs.msg import BallState, TableState
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.serialization import deserialize_message
from std_srvs.srv import Trigger

from billiard_shot.perception.gate import MAX_DEVIATION
from billiard_shot.perception.tracker import BallTracker, TrackerSettings
from billiard_shot.ros import parameters
from billiard_shot.ros.conversions import ball_message, picture_time, time_of
from billiard_shot.ros.detections import class_counts_of, class_names_of, detected_balls, Frames
from billiard_shot.ros.node_runner import LATCHED, spin_node, steady_timer
from billiard_shot.ros.parameters import checked, OfTable
from billiard_shot.scene import Scene
from billiard_shot.scene.fields import number
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.table.run.outline import outline_of

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

    Detections that are not balls, by their class or by the gate (billiard_shot.perception.gate),
    are ignored; the log has their number. A message with more balls than a table can have, or with
    a stamp ahead of the clock, is ignored as a whole. All other messages are pictures, also those
    without detections.

    `table_state` is published after every picture, and repeated if there is none, with the stamp
    of the last picture. The service `~/reset` (std_srvs/srv/Trigger) forgets all balls. Its
    parameters are `TableTrackerParameters` and `TrackerSettings`.
    """

    def __init__(self, detections_type: type) -> None:
        super().__init__('table_tracker')
        parameters.declare(self, TableTrackerParameters, TrackerSettings)
        own = parameters.read(TableTrackerParameters, self)
        scene = Scene.load(own.scene)
        names = {name: name for name in (CUE_BALL, *scene.balls)}
        names |= class_names_of(own.class_names)
        self._reading = names, own.min_score, own.detection_noise**2
        self._detections_type = detections_type
        self._ignored: Counter[str] = Counter()  # by reason, since the log had them
        self._told = -math.inf  # when that was [s]
        self._tracker = BallTracker(
            scene.ball.radius,
            parameters.read(TrackerSettings, self),
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
