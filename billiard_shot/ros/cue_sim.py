"""The node `cue_sim`: a simulated mechanism, which stops by itself when commands cease."""

from collections.abc import Sequence
import math
from time import monotonic

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from billiard_shot.cue.mechanism import BASE_Z, INCLINE, Mechanism
from billiard_shot.cue.placing import travel_base
from billiard_shot.cue.simulated import SimulatedMechanism
from billiard_shot.ros import cue_conversions as conversions
from billiard_shot.ros import cue_parameters, parameters
from billiard_shot.ros.running import be_urgent, run
from billiard_shot.ros.writing_time import written

CATCH_UP = 0.25
"""If the process did not run for longer than this, the mechanism paused meanwhile [s]."""


class CueSim(Node):
    """
    Node that moves as the topic of its parameter `actuation_topic` commands.

    That topic is of trajectory_msgs/msg/JointTrajectory; `header.frame_id` names the driver and
    numbers the command. A trajectory is followed from when it first arrives, as long as it is
    repeated, under the same number, more often than every `deadline` seconds; one point at stamp 0
    without speed is a command to stop. Trajectories that are older than `deadline`, that have a
    lower number than one before, or that come from a second driver are refused.
    Publishes `joint_states` (sensor_msgs/msg/JointState). Faults are parameters that can be set at
    any time. Its parameters are `cue_parameters.CUE_SIM`.

    The mechanism pauses with this process, and every step on its way is published: it stands for a
    machine with a processor of its own, which misses nothing because a desktop computer is busy.
    """

    def __init__(self) -> None:
        super().__init__('cue_sim')
        parameters.declare(self, cue_parameters.CUE_SIM)
        # It stands for a machine with a processor of its own.
        be_urgent(self, self.get_parameter('niceness').value)
        mechanism = Mechanism.load(self.get_parameter('mechanism').value)
        self._names = self.get_parameter('joint_names').value
        self._deadline = self.get_parameter('deadline').value
        self._period = 1.0 / self.get_parameter('rate').value
        self._now, self._behind, self._ran = 0.0, 0.0, monotonic()
        self._mechanism = SimulatedMechanism(
            mechanism,
            cue_parameters.imperfections_of(self),
            self._deadline,
            _home(mechanism),
            self._now,
            self.get_parameter('seed').value,
        )
        self._break()
        self.add_post_set_parameters_callback(lambda _: self._break())
        self._driver, self._number, self._path = '', 0, None
        self._heard = -math.inf  # the last command that was followed
        self._followed = 0  # paths so far
        self._refused: str | None = None  # name of the last command that was refused
        self._joints = self.create_publisher(JointState, 'joint_states', 10)
        self.create_subscription(
            JointTrajectory, self.get_parameter('actuation_topic').value, self._command, 1
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(self._period, self._move, clock=steady)
        self.get_logger().info('ready: a simulated mechanism')

    def _break(self) -> None:
        """Take over the faults that are wanted."""
        self._mechanism.faults = cue_parameters.faults_of(self)

    def _command(self, message: JointTrajectory, info: dict[str, int]) -> None:
        try:
            driver, number = conversions.command_of(message)
            if conversions.is_stop(message):
                if driver == self._driver:
                    self._number = max(number, self._number)
            else:
                steady = monotonic()
                self._take(message, driver, number, steady - written(info, steady))
                self._heard = self._now
                self._mechanism.follow(self._path, self._followed, self._now)
        except ValueError as error:
            if message.header.frame_id != self._refused:  # say so once, not at every repetition
                self.get_logger().error(f'ignored a command: {error}')
            self._refused = message.header.frame_id
        if conversions.is_stop(message):  # obeyed from every sender, under every number
            self._mechanism.stop(self._now)

    def _take(self, message: JointTrajectory, driver: str, number: int, age: float) -> None:
        """
        Take over a trajectory that was written `age` seconds ago, if it is a new one.

        Raises
        ------
        ValueError
            If the trajectory must not be followed.

        """
        if age > self._deadline:
            raise ValueError(
                f'command {number} was written {age:.3g} s ago, more than {self._deadline:g} s'
            )
        if driver != self._driver and self._now - self._heard <= self._deadline:
            raise ValueError(f'driver {driver}: driver {self._driver} commands the mechanism')
        if driver == self._driver and number < self._number:
            raise ValueError(f'command {number} comes after command {self._number}')
        if (driver, number) == (self._driver, self._number):
            return
        late = 1e-9 * (self.get_clock().now() - Time.from_msg(message.header.stamp)).nanoseconds
        if late > self._deadline:
            raise ValueError(
                f'command {number} was decided {late:.3g} s ago, more than {self._deadline:g} s'
            )
        path = conversions.path_of(message, self._names)
        self._driver, self._number, self._path = driver, number, path
        self._followed += 1

    def _move(self) -> None:
        """Take all steps that are due, and publish each."""
        now = monotonic()
        self._behind = min(self._behind + now - self._ran, CATCH_UP)
        self._ran = now
        while self._behind >= self._period:
            self._behind -= self._period
            self._now += self._period
            self._mechanism.advance(self._now)
            position, velocity = self._mechanism.measured()
            stamp = self.get_clock().now() - Duration(nanoseconds=int(1e9 * self._behind))
            self._joints.publish(
                conversions.joints_message(self._names, position, velocity, stamp.to_msg())
            )
        for stop in self._mechanism.stops:
            cause = (
                'stopped by command'
                if stop.commanded
                else f'stopped by itself: no command for {stop.silence:.3f} s'
            )
            self.get_logger().info(f'{cause}; at rest after {stop.braking:.3f} s')
        self._mechanism.stops.clear()


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
