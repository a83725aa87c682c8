"""Commands to a joint_trajectory_controller of ros2_control, as short goals that are renewed."""

from typing import Any

import numpy as np
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.task import Future
from rclpy.time import Time
from std_msgs.msg import Header

from billiard_shot.cue.clock import steady_time
from billiard_shot.cue.excerpt import braked, excerpt
from billiard_shot.cue.execution import Command
from billiard_shot.cue.joint_trajectory import JointTrajectory
from billiard_shot.records import Array
from billiard_shot.ros import cue_conversions as conversions
from billiard_shot.ros.command_topic import FAREWELL

COMMAND_HORIZON = 0.5
"""
Time of motion that a goal contains before its brake [s].

A controller follows its last goal to the end, even if the driver has died meanwhile.
"""

RENEWAL = 0.1
"""Time between two goals for the same trajectory [s]."""

LEAD = 0.05
"""Time from the decision to the start of a trajectory, for the way of the goal [s]."""

CONTROLLER_TIMEOUT = 1.0
"""Longest time in which the controller accepts or rejects a goal [s]."""


class ControllerClient:
    """
    Sends commands as goals of the action control_msgs/action/FollowJointTrajectory.

    A goal contains the trajectory from its start to `COMMAND_HORIZON` from now, and a brake. The
    next goal replaces it before the brake begins. All goals for a trajectory have the stamp of its
    start, so that the controller goes on where it is. A stop is a goal with a brake from the
    measured motion; if the joints are not known, the last goal is cancelled, and the controller
    holds.

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
        self._command: Command | None = None
        self._start = 0  # ROS time of the start of the trajectory [ns]
        self._covered = 0.0  # time of the trajectory up to which the last goal goes [s]
        self._sent = -np.inf  # steady time of the last goal [s]
        self._newest: Future[Any] | None = None  # answer to the last goal
        self._handle: ClientGoalHandle[Any, Any, Any] | None = None  # of the last accepted goal
        self._failure = ''

    @property
    def problem(self) -> str:
        """Return why the controller does not follow the commands; '' if it does."""
        if not self._client.server_is_ready():
            return f'controller: there is no action server {self._action}'
        waited = steady_time() - self._sent
        if self._newest and not self._newest.done() and waited > CONTROLLER_TIMEOUT:
            return f'controller: no answer to a goal for {waited:.2g} s'
        return self._failure

    def send(self, command: Command, decided: int, position: Array, velocity: Array) -> None:
        """Send a new command, decided at a ROS time [ns], for joints (6,) that move so."""
        self._command = command
        if command.trajectory is None:
            self._stop(position, velocity)
            return
        self._start = decided + int(1e9 * LEAD)
        self._covered = 0.0
        self._renew()

    def repeat(self) -> None:
        """Send the next goal for the current trajectory, if it is due."""
        if steady_time() - self._sent < RENEWAL or self._command is None:
            return
        trajectory = self._command.trajectory
        if trajectory is not None and self._covered < trajectory.duration:
            self._renew()

    def other_drivers(self) -> list[str]:
        """Other nodes are not known: a controller does not tell who sends goals."""
        return []

    def flush(self) -> None:
        """Wait until the controller has answered the last goal."""
        if self._newest and not self._newest.done() and self._client.server_is_ready():
            executor = SingleThreadedExecutor()
            executor.add_node(self._node)
            executor.spin_until_future_complete(self._newest, FAREWELL)

    def close(self) -> None:
        """Withdraw the client."""
        self._client.destroy()

    def _renew(self) -> None:
        assert self._command
        trajectory = self._command.trajectory
        assert trajectory
        passed = 1e-9 * (self._node.get_clock().now().nanoseconds - self._start)
        end = max(passed + COMMAND_HORIZON, self._command.whole)
        self._covered = end
        self._send(excerpt(trajectory, end, self._limits), self._start)

    def _stop(self, position: Array, velocity: Array) -> None:
        if not (np.isfinite(position).all() and np.isfinite(velocity).all()):
            if self._handle:
                self._handle.cancel_goal_async()
            return
        still = np.zeros_like(position)
        time, target = braked(position, velocity, still, self._limits)
        rest = (np.array([row]) for row in (target, still, still))
        self._send(JointTrajectory(np.array([time]), *rest), 0)  # 0: now

    def _send(self, trajectory: JointTrajectory, start: int) -> None:
        self._sent = steady_time()
        goal = self._kind.Goal()
        goal.trajectory = conversions.joint_trajectory_message(
            trajectory, self._names, Header(stamp=Time(nanoseconds=start).to_msg())
        )
        sent = self._newest = self._client.send_goal_async(goal)
        sent.add_done_callback(self._on_answer)

    def _on_answer(self, sent: 'Future[Any]') -> None:
        handle = sent.result()
        if sent is not self._newest or handle is None:
            return
        if not handle.accepted:
            self._failure = 'controller: it has rejected a goal; its log says why'
            if self._handle:
                self._handle.cancel_goal_async()
            return
        self._failure, self._handle = '', handle
        handle.get_result_async().add_done_callback(
            lambda ended: self._on_result(sent, ended.result())
        )

    def _on_result(self, sent: 'Future[Any]', answer: Any) -> None:
        """Note an error, unless a newer goal has replaced this one."""
        result = answer.result
        if sent is self._newest and result.error_code != result.SUCCESSFUL:
            constants = (each for each in dir(result) if each.isupper())
            names = (each for each in constants if getattr(result, each) == result.error_code)
            name = next(names, f'error {result.error_code}')
            self._failure = f'controller: {name}: {result.error_string}'
