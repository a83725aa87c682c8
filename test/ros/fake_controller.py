"""The controller of the example, with a fault: it can let a goal fail."""

import contextlib
from pathlib import Path
import sys

sys.path.append(str(Path(__file__).resolve().parents[2] / 'docs' / 'examples'))

from control_msgs.action import FollowJointTrajectory
import rclpy
from rclpy.executors import ExternalShutdownException
from std_srvs.srv import Trigger
from trajectory_server import TrajectoryServer

Result = FollowJointTrajectory.Result


class FakeController(TrajectoryServer):
    def __init__(self):
        super().__init__()
        self.create_service(Trigger, '~/violate', self.violate)

    def violate(self, _, response):
        """Let the active goal fail."""
        code, text = Result.PATH_TOLERANCE_VIOLATED, 'base_x is 0.1 m off'
        self.goal.ended.set_result(Result(error_code=code, error_string=text))
        response.success = True
        return response


def main():
    rclpy.init(args=sys.argv)
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(FakeController())


if __name__ == '__main__':
    main()
