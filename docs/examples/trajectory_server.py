"""A controller of the cue's joints: follows the goals of the driver, with simulated motors."""

from control_msgs.action import FollowJointTrajectory as Follow
import numpy as np
import rclpy
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.node import Node
from rclpy.task import Future
from scipy.interpolate import BPoly
from sensor_msgs.msg import JointState

START = {'base_x': 0, 'base_y': 0, 'base_z': 0.5, 'azimuth': 0, 'incline': 0.6, 'stroke': 0}


def seconds(time):
    return time.sec + 1e-9 * time.nanosec


class TrajectoryServer(Node):
    def __init__(self):
        super().__init__('joint_trajectory_controller')
        self.goal = None  # the last goal
        self.path = BPoly([[list(START.values())]] * 3, [0.0, 1.0])  # at rest
        self.joints = self.create_publisher(JointState, 'joint_states', 10)
        self.server = ActionServer(self, Follow, '~/follow_joint_trajectory', self.report)
        self.server.register_goal_callback(self.check)
        self.server.register_handle_accepted_callback(self.begin)
        self.server.register_cancel_callback(lambda _: CancelResponse.ACCEPT)
        self.create_timer(0.01, self.move)

    def now(self):
        return seconds(self.get_clock().now().to_msg())

    def motion(self, time):  # positions, velocities, accelerations; a real machine measures them
        return [self.path(min(time, self.path.x[-1]), order) for order in range(3)]

    def check(self, goal):
        names, points = goal.trajectory.joint_names, goal.trajectory.points
        start = seconds(goal.trajectory.header.stamp) or self.now()  # 0: now
        ahead = points and start + seconds(points[-1].time_from_start) > self.now()
        fits = ahead and sorted(names) == sorted(START) and not any(points[-1].velocities)
        return GoalResponse.ACCEPT if fits else GoalResponse.REJECT

    def begin(self, goal):  # go on from the motion of the moment, to the points that are ahead
        if self.goal:
            self.goal.ended.set_result(Follow.Result(error_code=-1))  # replaced: INVALID_GOAL
        trajectory, now = goal.request.trajectory, self.now()
        order = [trajectory.joint_names.index(name) for name in START]
        knots = {now: self.motion(now)}
        for each in trajectory.points:
            time = (seconds(trajectory.header.stamp) or now) + seconds(each.time_from_start)
            rows = each.positions, each.velocities, each.accelerations
            if time > now:
                knots[time] = [np.array(row)[order] for row in rows]
        if len(knots) > 1:  # else all points have passed meanwhile
            self.path = BPoly.from_derivatives(list(knots), list(knots.values()))  # quintic
        self.goal, goal.ended = goal, Future(executor=self.executor)
        goal.execute()

    async def report(self, goal):
        result = await goal.ended
        end = goal.abort if result.error_code else goal.succeed
        (goal.canceled if goal.is_cancel_requested else end)()
        return result

    def move(self):
        stamp = self.get_clock().now().to_msg()
        position, velocity, _ = map(list, self.motion(seconds(stamp)))
        joints = JointState(name=list(START), position=position, velocity=velocity)
        joints.header.stamp = stamp
        self.joints.publish(joints)
        if self.goal and self.goal.is_cancel_requested:
            self.path = BPoly([[position]] * 3, [0.0, 1.0])  # a real machine brakes first
        if self.goal and seconds(stamp) >= self.path.x[-1]:
            self.goal.ended.set_result(Follow.Result())


if __name__ == '__main__':
    rclpy.init()
    rclpy.spin(TrajectoryServer())
