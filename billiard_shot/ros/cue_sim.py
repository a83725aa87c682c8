"""The node `cue_sim`: a simulated mechanism, which stops by itself when commands cease."""
from collections.abc import Sequence
from time import monotonic

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from billiard_shot.cue.mechanism import BASE_Z, INCLINE, Mechanism
from billiard_shot.cue.placing import travel_base
from billiard_shot.cue.simulated import SimulatedMechanism
from billiard_shot.ros import cue_conversions as conversions
from billiard_shot.ros import cue_parameters, parameters
from billiard_shot.ros.running import be_urgent, run

COMMANDS = 10
"""Commands that may wait to be read."""


class CueSim(Node):
    """
    Node that moves as the topic of its parameter `actuation_topic` commands.

    That topic is of trajectory_msgs/msg/JointTrajectory. A trajectory is followed from when it
    first arrives, as long as it is repeated, under the same stamp, more often than every
    `deadline` seconds; one point at stamp 0 without speed is a command to stop. Publishes
    `joint_states` (sensor_msgs/msg/JointState). Faults are parameters that can be set at any time.
    Its parameters are `cue_parameters.CUE_SIM`.
    """

    def __init__(self) -> None:
        super().__init__('cue_sim')
        parameters.declare(self, cue_parameters.CUE_SIM)
        # It stands for a machine with a processor of its own.
        be_urgent(self, self.get_parameter('niceness').value)
        mechanism = Mechanism.load(self.get_parameter('mechanism').value)
        self._names = self.get_parameter('joint_names').value
        self._mechanism = SimulatedMechanism(
            mechanism, cue_parameters.imperfections_of(self), self.get_parameter('deadline').value,
            _home(mechanism), monotonic(), self.get_parameter('seed').value)
        self._break()
        self.add_post_set_parameters_callback(lambda _: self._break())
        self._key, self._path = 0, None
        self._abandoned = 0
        self._joints = self.create_publisher(JointState, 'joint_states', 10)
        self.create_subscription(
            JointTrajectory, self.get_parameter('actuation_topic').value, self._command, COMMANDS)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / self.get_parameter('rate').value, self._publish, clock=steady)
        self.get_logger().info('ready: a simulated mechanism')

    def _break(self) -> None:
        """Take over the faults that are wanted."""
        self._mechanism.faults = cue_parameters.faults_of(self)

    def _command(self, message: JointTrajectory) -> None:
        now = monotonic()
        if conversions.is_stop(message):
            self._mechanism.stop(now)
            return
        key = conversions.key_of(message.header.stamp)
        if key > self._key:
            try:
                self._key, self._path = key, conversions.path_of(message, self._names)
            except ValueError as error:
                self.get_logger().error(f'ignored a trajectory: {error}')
        if key == self._key and self._path:
            self._mechanism.follow(self._path, key, now)

    def _publish(self) -> None:
        self._mechanism.advance(monotonic())
        if self._mechanism.abandoned > self._abandoned:
            self._abandoned = self._mechanism.abandoned
            self.get_logger().warning('stops by itself: nobody commands')
        position, velocity = self._mechanism.measured()
        self._joints.publish(conversions.joints_message(
            self._names, position, velocity, self.get_clock().now().to_msg()))


def _home(mechanism: Mechanism) -> np.ndarray:
    """Joints at the start: over the middle of the table, as high as the carriage travels."""
    least, most = np.array([(axis.least, axis.most) for axis in mechanism.axes]).T
    home = np.clip(0.0, least, most)
    home[BASE_Z] = travel_base(mechanism, mechanism.base_z.least)
    home[INCLINE] = 0.5 * (least + most)[INCLINE]
    return home


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    run(CueSim, 'cue_sim', args)


if __name__ == '__main__':
    main()
