"""The node `cue_model`: publishes the robot model and the transforms of the mechanical cue."""

from collections.abc import Sequence
from dataclasses import dataclass
import math
from time import monotonic
from typing import ClassVar

from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Header, String

from billiard_shot.cue.inputs import JointFeedback
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.model import joints_of, transforms, urdf_of
from billiard_shot.ros import parameters
from billiard_shot.ros.conversions import filled
from billiard_shot.ros.node_runner import LATCHED, spin_node
from billiard_shot.ros.parameters import OfMechanism, OfTable
from billiard_shot.scene.fields import number

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # PyPI has no wheel for it
    TFMessage = None

TRANSFORMS = QoSProfile(depth=100)
"""QoS with which tf2_ros publishes transforms."""


@dataclass(frozen=True)
class CueModelParameters(OfTable, OfMechanism):
    """
    Parameters of the node.

    Parameters
    ----------
    rate : float
        Highest rate at which transforms are published [Hz].

    """

    READ_ONLY: ClassVar = None
    rate: float = number('Hz', minimum=1.0, maximum=1000.0, default=50.0)


class CueModel(Node):
    """
    Node that does what robot_state_publisher does, for the mechanical cue alone.

    Publishes the robot model (URDF) on `robot_description` (std_msgs/msg/String), latched, and
    the transforms from the table's frame to the tip on `/tf` (tf2_msgs/msg/TFMessage), for the
    joints in `joint_states` (sensor_msgs/msg/JointState). It does not need `incline_angle` in
    `joint_states`, because the elevation follows from the length of the incline's actuator.
    Without the package tf2_msgs it publishes no transforms. Its parameters are
    `CueModelParameters`.
    """

    def __init__(self) -> None:
        super().__init__('cue_model')
        parameters.declare(self, CueModelParameters)
        own = parameters.values_of(CueModelParameters, self)
        self._mechanism = Mechanism.load(own.mechanism)
        self._joints = joints_of(self._mechanism, own.frame, own.joint_names)
        self._feedback = JointFeedback(own.joint_names)
        self._period = 1.0 / own.rate
        self._published = -math.inf
        description = self.create_publisher(String, 'robot_description', LATCHED)
        model = urdf_of(self._mechanism, own.frame, own.joint_names)
        description.publish(String(data=model))
        if TFMessage is None:
            self.get_logger().warning('no transforms on /tf: the package tf2_msgs is missing')
        else:
            self._transforms = self.create_publisher(TFMessage, '/tf', TRANSFORMS)
            self.create_subscription(JointState, 'joint_states', self._on_joints, 50)
        self.get_logger().info('ready: describes the mechanical cue')

    def _on_joints(self, message: JointState) -> None:
        """Publish the transforms, unless the last ones are quite new."""
        now = monotonic()
        joints = self._feedback.update(message.name, message.position, message.velocity)
        if joints is None or now - self._published < self._period:
            return
        self._published = now
        try:
            found = transforms(self._mechanism, self._joints, joints[0])
        except ValueError as error:
            self.get_logger().warning(f'no transforms: {error}', throttle_duration_sec=5.0)
            return
        self._transforms.publish(
            TFMessage(
                transforms=[
                    TransformStamped(
                        header=Header(frame_id=each.parent, stamp=message.header.stamp),
                        child_frame_id=each.child,
                        transform=Transform(
                            translation=filled(Vector3, each.translation),
                            rotation=filled(Quaternion, each.quaternion),
                        ),
                    )
                    for each in found
                ]
            )
        )


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    spin_node(CueModel, 'cue_model', args)
