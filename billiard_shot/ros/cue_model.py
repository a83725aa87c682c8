"""The node `cue_model`: publishes the robot model and the transforms of the mechanical cue."""

from collections.abc import Sequence

from geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3
from rclpy.node import Node
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Header, String

from billiard_shot.cue import model
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.urdf import urdf_of
from billiard_shot.ros import cue_conversions, cue_parameters, parameters
from billiard_shot.ros.node_runner import LATCHED, run, steady_timer

try:
    from tf2_msgs.msg import TFMessage
except ImportError:  # PyPI has no wheel for it
    TFMessage = None

TRANSFORMS = QoSProfile(depth=100)
"""QoS with which tf2_ros publishes transforms."""


class CueModel(Node):
    """
    Node that does what robot_state_publisher does, for the mechanical cue alone.

    Publishes the robot model (URDF) on `robot_description` (std_msgs/msg/String), latched, and
    the transforms from the table's frame to the tip on `/tf` (tf2_msgs/msg/TFMessage), for the
    joints in `joint_states` (sensor_msgs/msg/JointState). It does not need `incline_angle` in
    `joint_states`, because the elevation follows from the length of the incline's actuator.
    Without the package tf2_msgs it publishes no transforms. Its parameters are
    `cue_parameters.CUE_MODEL`.
    """

    def __init__(self) -> None:
        super().__init__('cue_model')
        parameters.declare(self, cue_parameters.CUE_MODEL)
        self._mechanism = Mechanism.load(self.get_parameter('mechanism').value)
        self._names = self.get_parameter('joint_names').value
        self._frame = self.get_parameter('frame').value
        self._message: JointState | None = None
        description = self.create_publisher(String, 'robot_description', LATCHED)
        description.publish(
            String(
                data=urdf_of(
                    self._mechanism,
                    self._frame,
                    self._names,
                    self.get_parameter('incline_joint').value,
                )
            )
        )
        if TFMessage is None:
            self.get_logger().warning('no transforms on /tf: the package tf2_msgs is missing')
        else:
            self._transforms = self.create_publisher(TFMessage, '/tf', TRANSFORMS)
            self.create_subscription(JointState, 'joint_states', self._on_joints, 50)
            steady_timer(self, 1.0 / self.get_parameter('rate').value, self._publish)
        self.get_logger().info('ready: describes the mechanical cue')

    def _on_joints(self, message: JointState) -> None:
        if set(self._names) <= set(message.name):
            self._message = message

    def _publish(self) -> None:
        """Publish the transforms for the last joints, once per message."""
        message, self._message = self._message, None
        if message is None:
            return
        joints = cue_conversions.joints_of(message, self._names)
        try:
            found = (
                () if joints is None else model.transforms(self._mechanism, joints[0], self._frame)
            )
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
                            translation=Vector3(
                                **dict(zip('xyz', each.translation.tolist(), strict=True))
                            ),
                            rotation=Quaternion(**dict(zip('xyzw', each.quaternion, strict=True))),
                        ),
                    )
                    for each in found
                ]
            )
        )


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    run(CueModel, 'cue_model', args)


if __name__ == '__main__':
    main()
