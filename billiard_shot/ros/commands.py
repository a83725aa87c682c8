"""Commands for the mechanism: a topic, or goals of a joint_trajectory_controller."""

from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode
from rclpy.task import Future
from rclpy.time import Time
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage

from billiard_shot.cue.controller import Command
from billiard_shot.cue.inputs import steady_time
from billiard_shot.cue.joint_trajectory import braked, excerpt, JointTrajectory
from billiard_shot.records import Array
from billiard_shot.ros import conversions
from billiard_shot.ros.node_runner import publishers_of, UNKNOWN_NODE

FAREWELL = 0.5
"""Longest time that an ending driver waits until the mechanism has received the stop [s]."""


class CommandTopic:
    """
    Publishes commands as trajectory_msgs/msg/JointTrajectory.

    `header.stamp` is the time of the decision: if this process pauses between decision and
    publication, the mechanism sees that the command is old. A command that is repeated keeps its
    stamp.
    """

    awaits_answer = False

    def __init__(self, node: LifecycleNode, topic: str, names: list[str], frame: str) -> None:
        self._node, self._names, self._frame = node, names, frame
        self._publisher = node.create_publisher(JointTrajectoryMessage, topic, 1)
        self._message: JointTrajectoryMessage | None = None

    def send(self, command: Command, decided: int, *_: Array) -> None:
        """Publish a new command, decided at a ROS time [ns]."""
        if command.trajectory is None:
            self._message = conversions.stop_message(self._names, self._frame)
        else:
            stamp = Time(nanoseconds=decided).to_msg()
            self._message = conversions.joint_trajectory_message(
                command.trajectory, self._names, Header(stamp=stamp, frame_id=self._frame)
            )
        self._publisher.publish(self._message)

    def repeat(self, *_: object) -> None:
        """Publish the last command again."""
        if self._message:
            self._publisher.publish(self._message)

    @property
    def problem(self) -> str:
        """Return which other nodes publish commands; '' if there are none."""
        topic, own = self._publisher.topic_name, self._node.get_fully_qualified_name()
        if self._node.count_publishers(topic) < 2:
            return ''
        nodes = list(publishers_of(self._node, topic).values())
        if own in nodes:
            nodes.remove(own)
        unknown = f'_NODE_NAMESPACE_UNKNOWN_/{UNKNOWN_NODE}'
        names = ', '.join(nodes).replace(unknown, 'its name is not known yet')
        return f'another node commands the mechanism: {names}' if nodes else ''

    failure = problem

    def flush(self) -> None:
        """Wait until the mechanism has received the last command."""
        self._publisher.wait_for_all_acked(Duration(seconds=FAREWELL))

    def close(self) -> None:
        """
        Withdraw the publisher.

        The end of a process does not withdraw it. A new driver would see this driver until its
        lease expires, 20 s later, and would report it as a second driver.
        """
        self._node.destroy_publisher(self._publisher)


GOAL_TIMEOUT = 1.0
"""Longest time in which the controller accepts or rejects a goal [s]."""


class GoalSequence:
    """
    Sends goals of control_msgs/action/FollowJointTrajectory, and hears how they end.

    A new goal gives up the goal before it if that has not been answered. If the controller accepts
    the earlier goal later, that goal is cancelled at once: a controller with several threads may
    have begun it after the new goal. A failure is a goal that is rejected, not followed, or not
    answered within `GOAL_TIMEOUT`. It lasts until a goal is accepted.

    `send` sends a goal and returns the future of its handle; `clock` reads a steady clock [s].
    """

    def __init__(
        self, send: Callable[[Any], 'Future[Any]'], clock: Callable[[], float] = steady_time
    ) -> None:
        self._send, self._clock = send, clock
        self._sent = -np.inf  # time of the last goal [s]
        self._failure = ''
        self._newest: Future[Any] | None = None  # answer to the last goal, unless it is given up
        self._accepted: ClientGoalHandle[Any, Any, Any] | None = None  # the last accepted goal
        self._answers: deque[Future[Any]] = deque(maxlen=100)
        self._is_closed = False

    @property
    def age(self) -> float:
        """Time since the last goal was sent [s]."""
        return self._clock() - self._sent

    @property
    def awaits_answer(self) -> bool:
        """Whether the last goal has not been answered, but may still be in time."""
        return self._is_open and self.age <= GOAL_TIMEOUT

    @property
    def failure(self) -> str:
        """Return why the controller does not follow the goals; '' if it does."""
        if self._is_open and self.age > GOAL_TIMEOUT:
            return f'controller: no answer to a goal for {self.age:.2g} s'
        return self._failure

    @property
    def missing(self) -> int:
        """Number of goals and cancellations that the controller has not answered."""
        return sum(not each.done() for each in self._answers)

    def send(self, goal: Any) -> None:
        """Send a goal; give up the goal before it if that has not been answered."""
        self._failure, self._sent = self.failure, self._clock()
        self._newest = self._send(goal)
        self._answers.append(self._newest)
        self._newest.add_done_callback(self._on_answer)

    def cancel(self) -> None:
        """Cancel the last accepted goal, and give up a goal that has not been answered."""
        self._failure, self._newest = self.failure, None
        if self._accepted:
            self._answers.append(self._accepted.cancel_goal_async())
            self._accepted = None

    def close(self) -> None:
        """Ignore later answers: nothing can be sent any more."""
        self._is_closed = True

    @property
    def _is_open(self) -> bool:
        return self._newest is not None and not self._newest.done()

    def _on_answer(self, answer: 'Future[Any]') -> None:
        handle = answer.result()
        if handle is None or self._is_closed:
            return
        if answer is not self._newest:
            if handle.accepted:
                self._answers.append(handle.cancel_goal_async())
        elif handle.accepted:
            self._failure, self._accepted = '', handle
            handle.get_result_async().add_done_callback(
                lambda ended: self._on_result(answer, ended.result())
            )
        else:
            self._failure = 'controller: it has rejected a goal; its log says why'
            self.cancel()

    def _on_result(self, answer: 'Future[Any]', ended: Any) -> None:
        """Note an error, unless a newer goal has replaced this one."""
        result = ended.result
        if answer is self._newest and result.error_code != result.SUCCESSFUL:
            code, constants = result.error_code, filter(str.isupper, dir(result))
            names = (each for each in constants if getattr(result, each) == code)
            name = next(names, f'error {code}')
            self._failure = f'controller: {name}: {result.error_string}'


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
