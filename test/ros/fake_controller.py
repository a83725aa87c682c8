"""The controller of the example, with faults: it can let a goal fail, and reject a goal."""

import contextlib
from pathlib import Path
import sys

sys.path.append(str(Path(__file__).resolve().parents[2] / 'docs' / 'examples'))

from control_msgs.action import FollowJointTrajectory
import rclpy
from rclpy.action import GoalResponse
from rclpy.executors import ExternalShutdownException
from std_srvs.srv import Trigger
from trajectory_server import TrajectoryServer

Result = FollowJointTrajectory.Result


class FakeController(TrajectoryServer):
    def __init__(self):
        super().__init__()
        self.rejects = False
        self.create_service(Trigger, '~/violate', self.violate)
        self.create_service(Trigger, '~/reject', self.reject)

    def violate(self, _, response):
        """Let the active goal fail."""
        code, text = Result.PATH_TOLERANCE_VIOLATED, 'base_x is 0.1 m off'
        self.goal.ended.set_result(Result(error_code=code, error_string=text))
        response.success = True
        return response

    def reject(self, _, response):
        """Reject the next goal."""
        self.rejects = True
        response.success = True
        return response

    def check(self, goal):
        rejected, self.rejects = self.rejects, False
        return GoalResponse.REJECT if rejected else super().check(goal)


def main():
    rclpy.init(args=sys.argv)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(FakeController())


if __name__ == '__main__':
    main()
