"""Commands to a joint_trajectory_controller of ros2_control, as short goals that are renewed."""

from typing import Any

import numpy as np
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.time import Time
from std_msgs.msg import Header

from billiard_shot.cue.clock import steady_time
from billiard_shot.cue.excerpt import braked, excerpt
from billiard_shot.cue.execution import Command
from billiard_shot.cue.joint_trajectory import JointTrajectory
from billiard_shot.records import Array
from billiard_shot.ros import cue_conversions as conversions
from billiard_shot.ros.command_topic import FAREWELL
from billiard_shot.ros.goal_sequence import GOAL_TIMEOUT, GoalSequence

COMMAND_HORIZON = 0.5
"""
Time of motion that a goal contains before its brake [s].

A controller follows its last goal to the end, even if the driver has died meanwhile.
"""

RENEWAL = 0.1
"""Time between two goals for the same trajectory [s]."""

LEAD = 0.05
"""Time from the decision to the start of a trajectory, for the way of the goal [s]."""


class ControllerClient:
    """
    Sends commands as goals of the action control_msgs/action/FollowJointTrajectory.

    A goal contains the trajectory from its start to `COMMAND_HORIZON` from now, and a brake. The
    next goal replaces it before the brake begins. All goals for a trajectory have the stamp of its
    start, so that the controller goes on where it is. Each waits for the answer to the goal before
    it. A stop is a goal with a brake from the measured motion. It is sent at once, and again every
    second until it is accepted. If the joints are not known, the last goal is cancelled instead.

    Parameters
    ----------
    node : LifecycleNode
    action : str
        Name of the action.
    names : list of str
        Names of the joints, in the order of `mechanism.JOINTS`.
    accelerations : (6,) float array
        Largest accelerations of the joints [m/s^2, rad/s^2].

    Raises
    ------
    ValueError
        If the package control_msgs is missing.

    """

    def __init__(
        self, node: LifecycleNode, action: str, names: list[str], accelerations: Array
    ) -> None:
        try:
            from control_msgs.action import FollowJointTrajectory
        except ImportError:
            raise ValueError(
                "interface: 'follow_joint_trajectory' needs the package control_msgs, which is "
                'not installed'
            ) from None
        self._node, self._names, self._limits = node, names, accelerations
        self._kind = FollowJointTrajectory
        self._client: ActionClient[Any, Any, Any] = ActionClient(
            node, FollowJointTrajectory, action
        )
        self._action = node.resolve_topic_name(action)
        self._goals = GoalSequence(self._client.send_goal_async)
        self._command = Command(None)
        self._start = 0  # ROS time of the start of the trajectory [ns]
        self._covered = np.inf  # time of the command up to which goals were sent [s]; 0: none

    @property
    def problem(self) -> str:
        """Return why the controller does not follow the commands; '' if it does."""
        if not self._client.server_is_ready():
            return f'controller: there is no action server {self._action}'
        return self.failure

    @property
    def failure(self) -> str:
        """Return why the controller has not followed a command; '' if it has."""
        return self._goals.failure

    @property
    def awaits_answer(self) -> bool:
        """Whether a trajectory has to wait, because the last goal has not been answered."""
        return self._goals.awaits_answer

    def send(self, command: Command, decided: int, position: Array, velocity: Array) -> None:
        """Send a new command, decided at a ROS time [ns], for joints (6,) that move so."""
        self._command, self._covered = command, 0.0
        self.repeat(decided, position, velocity)

    def repeat(self, decided: int, position: Array, velocity: Array) -> None:
        """Send the next goal for the current command, if it is due, as `send` does."""
        trajectory, age = self._command.trajectory, self._goals.age
        if trajectory is None:
            if not self._covered or (self.failure and age > GOAL_TIMEOUT):
                self._stop(position, velocity)
        elif not self.awaits_answer and (
            not self._covered or (self._covered < trajectory.duration and age > RENEWAL)
        ):
            self._follow(trajectory, decided)

    def flush(self) -> None:
        """Wait until the controller has answered all goals, and has cancelled those given up."""
        executor = SingleThreadedExecutor()
        executor.add_node(self._node)
        deadline = steady_time() + FAREWELL
        while self._goals.missing and (left := deadline - steady_time()) > 0.0:
            executor.spin_once(left)

    def close(self) -> None:
        """Withdraw the client."""
        self._goals.close()  # an executor may still hold answers that it has taken
        self._client.destroy()

    def _follow(self, trajectory: JointTrajectory, decided: int) -> None:
        """Send the trajectory up to the horizon."""
        now = self._node.get_clock().now().nanoseconds
        if not self._covered:
            self._start = decided + int(1e9 * LEAD)
        if not self._covered and now > self._start:
            return  # this process paused; the controller would begin in the middle of a stroke
        self._covered = max(1e-9 * (now - self._start) + COMMAND_HORIZON, self._command.whole)
        self._send(excerpt(trajectory, self._covered, self._limits), self._start)

    def _stop(self, position: Array, velocity: Array) -> None:
        known = np.isfinite(position).all() and np.isfinite(velocity).all()
        if not (known and self._client.server_is_ready()):
            self._goals.cancel()
            return
        still = np.zeros_like(position)
        self._covered, target = braked(position, velocity, still, self._limits)
        rest = (np.array([row]) for row in (target, still, still))
        self._send(JointTrajectory(np.array([self._covered]), *rest), 0)  # 0: now

    def _send(self, trajectory: JointTrajectory, start: int) -> None:
        goal = self._kind.Goal()
        goal.trajectory = conversions.joint_trajectory_message(
            trajectory, self._names, Header(stamp=Time(nanoseconds=start).to_msg())
        )
        self._goals.send(goal)
