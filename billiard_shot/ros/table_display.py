"""The node `table_display`: shows the table, the current balls, and the mechanical cue."""

from collections.abc import Sequence
import math
from time import monotonic

from billiard_shot_msgs.msg import TableState
import numpy as np
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from billiard_shot.cue.feedback import JointFeedback
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.ros import cue_parameters, parameters, table_markers
from billiard_shot.ros.conversions import check_frame
from billiard_shot.ros.node_runner import LATCHED, spin_node
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL

CUE_PERIOD = 1 / 30
"""Time between two messages of a moving cue [s]."""

MIN_CHANGE = 1e-5
"""Smallest shown change of joints and balls [m, rad]; smaller ones may be noise."""


class TableDisplay(Node):
    """
    Node that publishes markers (visualization_msgs/msg/MarkerArray), latched.

    `~/table` shows the bed, cushions, rails and pockets of the scene. `~/balls` shows the balls of
    the topic `table_state` (billiard_shot_msgs/msg/TableState); until a message is received, it
    shows those of the scene. `~/cue` shows the mechanical cue for the joints in `joint_states`
    (sensor_msgs/msg/JointState). Its parameters are `cue_parameters.TABLE_DISPLAY`.
    """

    def __init__(self) -> None:
        super().__init__('table_display')
        self._table = self.create_publisher(MarkerArray, '~/table', LATCHED)
        self._balls = self.create_publisher(MarkerArray, '~/balls', LATCHED)
        self._cue = self.create_publisher(MarkerArray, '~/cue', LATCHED)
        parameters.declare(self, cue_parameters.TABLE_DISPLAY)
        self.add_post_set_parameters_callback(lambda _: self._show())
        self._shown, self._shown_at = np.full(6, np.nan), -math.inf
        self._show()
        self.create_subscription(TableState, 'table_state', self._show_balls, LATCHED)
        self.create_subscription(JointState, 'joint_states', self._on_joints, 50)
        self.get_logger().info('ready: shows the table')

    def _show(self) -> None:
        """Show the scene of the parameters."""
        self._places: table_markers.BallCentres = {}
        scene = Scene.load(self.get_parameter('scene').value)
        self._mechanism = Mechanism.load(self.get_parameter('mechanism').value)
        self._feedback = JointFeedback(self.get_parameter('joint_names').value)
        self._radius = scene.ball.radius
        self._table.publish(table_markers.table_markers(scene, parameters.table_header(self)))
        balls = {name: (x, y, self._radius) for name, (x, y) in scene.balls.items()}
        self._publish_balls({CUE_BALL: scene.cue_ball, **balls}, parameters.table_header(self))

    def _show_balls(self, message: TableState) -> None:
        try:
            check_frame('header.frame_id', message.header, self.get_parameter('frame').value)
        except ValueError as error:
            self.get_logger().error(f'ignored a table_state: {error}')
            return
        header = parameters.table_header(self, message.header.stamp)
        self._publish_balls(table_markers.ball_centres(message, self._radius), header)

    def _publish_balls(self, balls: table_markers.BallCentres, header: Header) -> None:
        """Show the balls, unless they are shown where they are."""
        if balls.keys() == self._places.keys() and all(
            math.dist(place, self._places[name]) < MIN_CHANGE for name, place in balls.items()
        ):
            return
        self._places = balls
        self._balls.publish(table_markers.ball_markers(balls, self._radius, header))

    def _on_joints(self, message: JointState) -> None:
        """Show the cue if it has moved, unless it was shown just now."""
        now = monotonic()
        found = self._feedback.update(message.name, message.position, message.velocity, now)
        if found is None or now - self._shown_at < CUE_PERIOD:
            return
        joints, _ = found
        if np.abs(joints - self._shown).max() < MIN_CHANGE:
            return
        self._shown, self._shown_at = joints, now
        try:
            header = parameters.table_header(self, message.header.stamp)
            self._cue.publish(table_markers.cue_markers(self._mechanism, joints, header))
        except ValueError as error:
            self.get_logger().warning(f'cue not shown: {error}', throttle_duration_sec=5.0)


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    spin_node(TableDisplay, 'table_display', args)


if __name__ == '__main__':
    main()
