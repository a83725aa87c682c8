"""Commands on a topic, repeated, for a mechanism that stops by itself when they cease."""

from rclpy.duration import Duration
from rclpy.lifecycle import LifecycleNode
from rclpy.time import Time
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory

from billiard_shot.cue.execution import Command
from billiard_shot.records import Array
from billiard_shot.ros import cue_conversions as conversions
from billiard_shot.ros.writing_time import publishers_of, UNKNOWN_NODE

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
        self._publisher = node.create_publisher(JointTrajectory, topic, 1)
        self._message: JointTrajectory | None = None

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
