"""
A node that behaves like joint_trajectory_controller and joint_state_broadcaster of ros2_control.

It accepts a goal of complete points whose times ascend, with all joints, that ends at rest and in
the future. A new goal replaces the active one and goes on from the commanded motion. It follows
goals exactly, on the clock of their stamps, and knows nothing of who sends them.
"""

import contextlib
import sys

from control_msgs.action import FollowJointTrajectory
import numpy as np
from quintic import quintic
import rclpy
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_srvs.srv import Trigger

from billiard_shot.cue.joint_trajectory import JointTrajectory
from billiard_shot.cue.kinematics import home
from billiard_shot.cue.mechanism import JOINTS, Mechanism
from billiard_shot.ros.cue_conversions import joints_message, seconds, trajectory_of

PERIOD = 0.01
"""Time between two messages with joints [s]."""


class FakeController(Node):
    def __init__(self):
        super().__init__('joint_trajectory_controller')
        self.motion = home(Mechanism()), np.zeros(6), np.zeros(6)
        self.trajectory, self.start = None, 0.0
        self.rejects = False
        self.active, self.ended = None, None
        self.publisher = self.create_publisher(JointState, 'joint_states', 10)
        self.server = ActionServer(
            self,
            FollowJointTrajectory,
            '~/follow_joint_trajectory',
            self.execute,
            goal_callback=self.check,
            handle_accepted_callback=self.accept,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        self.create_service(Trigger, '~/violate', self.violate)
        self.create_service(Trigger, '~/reject', self.reject)
        self.create_timer(PERIOD, self.step)

    @property
    def now(self):
        return 1e-9 * self.get_clock().now().nanoseconds

    def violate(self, _, response):
        """Let the active goal fail."""
        self.end(FollowJointTrajectory.Result.PATH_TOLERANCE_VIOLATED, 'base_x is 0.1 m off')
        self.hold()
        response.success = True
        return response

    def reject(self, _, response):
        """Reject the next goal."""
        self.rejects = True
        response.success = True
        return response

    def check(self, goal):
        message = goal.trajectory
        try:
            trajectory = trajectory_of(message, JOINTS)
        except ValueError as error:
            self.get_logger().error(str(error))
            return GoalResponse.REJECT
        start = seconds(message.header.stamp)
        rejected, self.rejects = self.rejects, False
        if rejected or trajectory.velocities[-1].any():
            return GoalResponse.REJECT
        if start and start + trajectory.duration < self.now:
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def accept(self, handle):
        self.end(
            FollowJointTrajectory.Result.INVALID_GOAL,
            'Current goal cancelled due to new incoming action.',
        )
        message = handle.request.trajectory
        trajectory = trajectory_of(message, JOINTS)
        self.start = seconds(message.header.stamp) or self.now
        before = self.now - self.start
        if before < trajectory.times[0]:  # come there from the current motion
            rows = (trajectory.positions, trajectory.velocities, trajectory.accelerations)
            trajectory = JointTrajectory(
                np.append(before, trajectory.times),
                *(np.vstack([now, row]) for now, row in zip(self.motion, rows, strict=True)),
            )
        self.trajectory = trajectory
        self.active, self.ended = handle, Future(executor=self.executor)
        handle.execute()

    async def execute(self, handle):
        error, text = await self.ended
        if handle.is_cancel_requested:
            handle.canceled()
        elif error:
            handle.abort()
        else:
            handle.succeed()
        return FollowJointTrajectory.Result(error_code=error, error_string=text)

    def end(self, error, text):
        if self.active:
            self.active = None
            self.ended.set_result((error, text))

    def hold(self):
        self.trajectory = None
        self.motion = self.motion[0], np.zeros(6), np.zeros(6)

    def step(self):
        if self.active and self.active.is_cancel_requested:
            self.end(0, '')
            self.hold()
        if self.trajectory:
            time = self.now - self.start
            if time >= self.trajectory.duration:
                self.motion = self.trajectory.positions[-1], np.zeros(6), np.zeros(6)
                self.trajectory = None
                self.end(0, '')
            else:
                self.motion = quintic(self.trajectory, time)
        position, velocity, _ = self.motion
        stamp = self.get_clock().now().to_msg()
        self.publisher.publish(joints_message(JOINTS, position, velocity, stamp))


def main():
    rclpy.init(args=sys.argv)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(FakeController())


if __name__ == '__main__':
    main()
