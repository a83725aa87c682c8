"""The node `table_sim`: a simulated table, whose balls move as the library predicts."""
from collections.abc import Sequence
from time import monotonic

from billiard_shot_msgs.msg import Strike, TableState
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import Trigger

from billiard_shot import predict
from billiard_shot.ros import cue_conversions as conversions
from billiard_shot.ros import cue_parameters, parameters
from billiard_shot.ros.conversions import CUE_BALL
from billiard_shot.ros.running import LATCHED, run, warm_up
from billiard_shot.table.trajectory import Trajectory


class TableSim(Node):
    """
    Node that publishes `table_state` (billiard_shot_msgs/msg/TableState), latched.

    The balls lie as the scene has them. The cue ball moves as a strike on the topic of the
    parameter `strike_topic` (billiard_shot_msgs/msg/Strike) makes it, and stays where it comes to
    rest; a strike while it still moves is ignored. The service `~/reset` (std_srvs/srv/Trigger)
    puts all balls back. Its parameters are `cue_parameters.TABLE_SIM`.
    """

    def __init__(self) -> None:
        super().__init__('table_sim')
        parameters.declare(self, cue_parameters.TABLE_SIM)
        self._scene = cue_parameters.guided_scene(self.get_parameter('scene').value)
        warm_up(self._scene)
        self._haste = self.get_parameter('haste').value
        self._snapshot = 0
        self._motion: Trajectory | None = None
        self._begin = 0.0
        self._table = self.create_publisher(TableState, 'table_state', LATCHED)
        self._timer = self.create_timer(
            1.0 / self.get_parameter('rate').value, self._move, autostart=False,
            clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._reset()
        self.create_subscription(
            Strike, self.get_parameter('strike_topic').value, self._strike, 10)
        self.create_service(Trigger, '~/reset', self._answer_reset)
        self.get_logger().info('ready: a simulated table')

    def _reset(self) -> None:
        self._timer.cancel()
        self._motion = None
        radius = self._scene.ball.radius
        self._balls = {name: (x, y, radius) for name, (x, y) in self._scene.balls.items()}
        self._balls[CUE_BALL] = self._scene.cue_ball
        self._publish()

    def _answer_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._reset()
        response.success = True
        response.message = f'snapshot {self._snapshot}'
        return response

    def _strike(self, message: Strike) -> None:
        if self._motion:
            self.get_logger().error('ignored a strike: the cue ball still moves')
            return
        ball = self._balls[CUE_BALL]
        try:
            stroke = conversions.stroke_of(message, ball)
        except ValueError as error:
            self.get_logger().error(f'ignored a strike: {error}')
            return
        shot = predict(self._scene, stroke, position=ball)
        self.get_logger().info(f'shot {message.shot_id!r}: {shot.status.name}: {shot.message}')
        if not shot.status.refused:
            self._motion, self._begin = shot.trajectory, monotonic()
            self._timer.reset()

    def _move(self) -> None:
        if not self._motion:
            return
        time = self._haste * (monotonic() - self._begin)
        x, y, z = self._motion.at(time).position.tolist()
        self._balls[CUE_BALL] = x, y, z
        if time >= self._motion.duration:
            self._timer.cancel()
            self._motion = None
        self._publish()

    def _publish(self) -> None:
        self._snapshot += 1
        self._table.publish(conversions.table_message(
            self._balls, self._snapshot, self.get_clock().now().to_msg()))


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    run(TableSim, 'table_sim', args)


if __name__ == '__main__':
    main()
