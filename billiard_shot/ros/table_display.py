"""The node `table_display`: shows the table and the current balls."""

from collections.abc import Sequence
from dataclasses import dataclass
import math

from billiard_shot_msgs.msg import TableState
from rclpy.node import Node
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from billiard_shot.ros import parameters, table_markers
from billiard_shot.ros.conversions import check_frame
from billiard_shot.ros.node_runner import LATCHED, spin_node
from billiard_shot.ros.parameters import check_scene, checked, OfTable
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL

MIN_CHANGE = 1e-5
"""Smallest shown motion of a ball [m]; a smaller one may be noise."""


@dataclass(frozen=True)
class TableDisplayParameters(OfTable):
    """
    Parameters of the node.

    Parameters
    ----------
    scene : str
        Table, and balls until table_state has been received: name of a bundled scene, or path of
        a YAML file.

    """

    scene: str = checked('paper', check_scene)


class TableDisplay(Node):
    """
    Node that publishes markers (visualization_msgs/msg/MarkerArray), latched.

    `~/table` shows the bed, cushions, rails and pockets of the scene. `~/balls` shows the balls of
    the topic `table_state` (billiard_shot_msgs/msg/TableState); until a message is received, it
    shows those of the scene. Its parameters are `TableDisplayParameters`.
    """

    def __init__(self) -> None:
        super().__init__('table_display')
        self._table = self.create_publisher(MarkerArray, '~/table', LATCHED)
        self._balls = self.create_publisher(MarkerArray, '~/balls', LATCHED)
        parameters.declare(self, TableDisplayParameters)
        self.add_post_set_parameters_callback(lambda _: self._show())
        self._show()
        self.create_subscription(TableState, 'table_state', self._show_balls, LATCHED)
        self.get_logger().info('ready: shows the table')

    def _show(self) -> None:
        """Show the scene of the parameters."""
        self._places: table_markers.BallCentres = {}
        scene = Scene.load(self.get_parameter('scene').value)
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


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    spin_node(TableDisplay, 'table_display', args)


if __name__ == '__main__':
    main()
