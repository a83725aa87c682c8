"""The node `table_display`: shows the table, and the balls where they lie now."""
from collections.abc import Sequence

from billiard_shot_msgs.msg import TableState
from rclpy.node import Node
from visualization_msgs.msg import MarkerArray

from billiard_shot.ros import parameters, table_markers
from billiard_shot.ros.conversions import CUE_BALL
from billiard_shot.ros.running import LATCHED, run
from billiard_shot.scene import Scene


class TableDisplay(Node):
    """
    Node that publishes markers (visualization_msgs/msg/MarkerArray), latched.

    `~/table`: bed, cushions, rails and pockets of the scene. `~/balls`: the balls where the topic
    `table_state` (billiard_shot_msgs/msg/TableState) has them and, until it has come in, where the
    scene has them. Its parameters are `parameters.TABLE_DISPLAY`.
    """

    def __init__(self) -> None:
        super().__init__('table_display')
        self._table = self.create_publisher(MarkerArray, '~/table', LATCHED)
        self._balls = self.create_publisher(MarkerArray, '~/balls', LATCHED)
        parameters.declare(self, parameters.TABLE_DISPLAY)
        self.add_post_set_parameters_callback(lambda _: self._show())
        self._show()
        self.create_subscription(TableState, 'table_state', self._show_balls, LATCHED)
        self.get_logger().info('ready: shows the table')

    def _show(self) -> None:
        """Show the scene, as the parameter names it."""
        scene = Scene.load(self.get_parameter('scene').value)
        self._radius = scene.ball.radius
        self._table.publish(table_markers.furniture_markers(scene, self._now()))
        balls = {name: (x, y, self._radius) for name, (x, y) in scene.balls.items()}
        self._publish_balls({CUE_BALL: scene.cue_ball, **balls})

    def _show_balls(self, message: TableState) -> None:
        self._publish_balls(table_markers.places_of(message, self._radius))

    def _publish_balls(self, balls: table_markers.Places) -> None:
        self._balls.publish(table_markers.ball_markers(balls, self._radius, self._now()))

    def _now(self):
        return self.get_clock().now().to_msg()


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    run(TableDisplay, 'table_display', args)


if __name__ == '__main__':
    main()
