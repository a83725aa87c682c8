"""The node `cue_sim`: a simulated mechanism, which stops by itself when commands cease."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math
from time import monotonic
from typing import Any, ClassVar

from rclpy.node import Node
from rclpy.time import Time
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage

from billiard_shot.cue.controller import LATEST_STOP, MIN_DURATION
from billiard_shot.cue.joint_trajectory import JointTrajectory
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.model import home
from billiard_shot.cue.simulated import Faults, Imperfections, SimulatedMechanism
from billiard_shot.ros import conversions, node_runner, parameters
from billiard_shot.ros.parameters import OfMechanism, OfUrgent
from billiard_shot.scene.fields import number, whole_number

CATCH_UP = 0.25
"""Longest time that is simulated after an interruption [s]; for the rest, the mechanism pauses."""


REST_RATE = 10.0
"""Rate at which joint_states is published at rest [Hz]."""


@dataclass(frozen=True)
class CueSimParameters(OfMechanism, OfUrgent):
    """
    Parameters of the node.

    Parameters
    ----------
    command_timeout : float
        If no command arrives for longer than this, the mechanism stops. A command older than this
        is refused [s].
    rate : float
        Rate at which joint_states is published [Hz].
    seed : int
        Seed of all random numbers.

    """

    READ_ONLY: ClassVar = None
    command_timeout: float = number('s', minimum=MIN_DURATION, maximum=LATEST_STOP, default=0.5)
    rate: float = number('Hz', minimum=10.0, maximum=1000.0, default=200.0)
    seed: int = whole_number(minimum=0, maximum=2**31 - 1, default=0)


class CueSim(Node):
    """
    Node that moves as commanded on the topic `cue_driver/actuation`.

    That topic has the type trajectory_msgs/msg/JointTrajectory; `header.stamp` identifies the
    command. A trajectory is followed from its first arrival on, as long as it is repeated with the
    same stamp at least every `command_timeout` seconds. A single point at stamp 0 with zero
    velocities is a command to stop. Trajectories are refused if they are older than
    `command_timeout`, if they are older than an earlier one, or if they come from a second
    publisher while the first one still commands.
    Publishes `joint_states` (sensor_msgs/msg/JointState), less often at rest. Faults are
    parameters that can be set at any time. Its parameters are `CueSimParameters`, `Imperfections`
    and `Faults`.

    If this process pauses, the mechanism pauses too. Every simulated step is published. The node
    stands for a machine with its own processor, which a busy desktop computer does not delay.
    """

    def __init__(self) -> None:
        super().__init__('cue_sim')
        parameters.declare(self, CueSimParameters, Imperfections, Faults)
        own = parameters.values_of(CueSimParameters, self)
        node_runner.set_niceness(self, own.niceness)
        mechanism = Mechanism.load(own.mechanism)
        self._names, self._command_timeout = own.joint_names, own.command_timeout
        self._fast, self._slow = 1.0 / own.rate, 1.0 / min(own.rate, REST_RATE)
        self._period = self._slow
        self._now, self._behind, self._ran = 0.0, 0.0, monotonic()
        self._mechanism = SimulatedMechanism(
            mechanism,
            parameters.values_of(Imperfections, self),
            own.command_timeout,
            home(mechanism),
            self._now,
            own.seed,
        )
        self._set_faults()
        self.add_post_set_parameters_callback(lambda _: self._set_faults())
        self._driver, self._stamp = b'', 0  # of the last trajectory
        self._trajectory: JointTrajectory | None = None
        self._last_command = -math.inf  # time of the last accepted command
        self._refused: tuple[bytes, int] | None = None  # the last refused command
        self._joints = self.create_publisher(JointState, 'joint_states', node_runner.JOINT_STATES)
        self.create_subscription(JointTrajectoryMessage, 'cue_driver/actuation', self._command, 1)
        self._timer = node_runner.steady_timer(self, self._period, self._move)
        self.get_logger().info('ready: a simulated mechanism')

    def _set_faults(self) -> None:
        """Apply the parameters of the faults."""
        self._mechanism.faults = parameters.values_of(Faults, self)

    def _command(self, message: JointTrajectoryMessage, info: Mapping[str, Any]) -> None:
        if conversions.is_stop(message):  # obeyed from every driver
            self._mechanism.stop(self._now)
            return
        driver, stamp = (
            node_runner.publisher_of(info),
            node_runner.nanoseconds(message.header.stamp),
        )
        steady = monotonic()
        try:
            trajectory = self._accept(
                message, driver, stamp, steady - node_runner.written(info, steady)
            )
        except ValueError as error:
            if (driver, stamp) != self._refused:  # log it once, not at every repetition
                self.get_logger().error(f'ignored a command: {error}')
            self._refused = driver, stamp
            return
        self._move()  # at rest, the last step may be long ago
        self._set_period(self._fast)
        self._last_command = self._now
        self._mechanism.command(trajectory, self._now)

    def _accept(
        self, message: JointTrajectoryMessage, driver: bytes, stamp: int, age: float
    ) -> JointTrajectory:
        """Return the trajectory of a command of some `age` [s]; raise ValueError to refuse it."""
        if age > self._command_timeout:
            raise ValueError(
                f'it was written {age:.3g} s ago, more than {self._command_timeout:g} s'
            )
        if driver != self._driver and self._now - self._last_command <= self._command_timeout:
            raise ValueError('another driver commands the mechanism')
        if self._trajectory and (driver, stamp) == (self._driver, self._stamp):
            return self._trajectory
        now = self.get_clock().now().nanoseconds
        if driver == self._driver and stamp < self._stamp <= now:  # else the clock was set
            raise ValueError('a later command has arrived before')
        if 1e-9 * (now - stamp) > self._command_timeout:
            raise ValueError(
                f'header.stamp must be at most {self._command_timeout:g} ago, got '
                f'{1e-9 * (now - stamp):.3g} (s)'
            )
        self._trajectory = conversions.trajectory_of(message, self._names)
        self._driver, self._stamp = driver, stamp
        return self._trajectory

    def _set_period(self, period: float) -> None:
        if period != self._period:
            self._period = period
            self._timer.timer_period_ns = round(1e9 * period)
            self._timer.reset()

    def _clocks(self) -> tuple[float, Time]:
        """Read the steady clock [s] and the ROS clock; repeat if interrupted between the two."""
        while True:
            now, ros_now = monotonic(), self.get_clock().now()
            if monotonic() - now < self._fast:
                return now, ros_now

    def _move(self) -> None:
        """
        Simulate all steps that are due, and publish each.

        Both clocks are read at the same moment. If the process were interrupted between the two
        readings, the stamps would be too late, and the next stamps would be earlier. The driver
        ignores messages with earlier stamps.
        """
        now, ros_now = self._clocks()
        self._behind = min(self._behind + now - self._ran, CATCH_UP)
        self._ran = now
        while self._behind >= self._period:
            self._behind -= self._period
            self._now += self._period
            self._mechanism.advance(self._now)
            position, velocity = self._mechanism.measured()
            # a clock that follows /clock begins at 0
            stamp = Time(nanoseconds=max(ros_now.nanoseconds - int(1e9 * self._behind), 0))
            self._joints.publish(
                conversions.joints_message(self._names, position, velocity, stamp.to_msg())
            )
        for stop in self._mechanism.stops:
            self.get_logger().info(stop)
        self._mechanism.stops.clear()
        if self._mechanism.stopped:
            self._set_period(self._slow)


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    node_runner.spin_node(CueSim, 'cue_sim', args)
