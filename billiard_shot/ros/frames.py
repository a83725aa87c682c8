"""Positions in other frames, from the transforms on `/tf` and `/tf_static`."""

import math
from typing import Any

from geometry_msgs.msg import TransformStamped
import numpy as np
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from billiard_shot.impact.bodies import rotation_matrix
from billiard_shot.perception import gate
from billiard_shot.records import Array
from billiard_shot.ros.conversions import seconds, xyz, xyzw

MAX_APART = 0.1
"""Longest time between a transform that changes and the position that it transforms [s]."""

STATIC = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""QoS of `/tf_static`, whose publishers are latched."""


class Frames:
    """
    The latest transforms between frames.

    tf2_ros is not used, because PyPI does not have it. It interpolates transforms; a camera that
    moves needs transforms at its rate here.

    Parameters
    ----------
    node : Node
        Node that listens. Without the package tf2_msgs it hears nothing.

    """

    def __init__(self, node: Node) -> None:
        self._latest: dict[str, tuple[TransformStamped, bool]] = {}  # by child; whether static
        self.missing = ''
        try:
            from tf2_msgs.msg import TFMessage
        except ImportError:
            self.missing = 'the package tf2_msgs is missing'
            return
        node.create_subscription(TFMessage, '/tf', lambda message: self.hear(message, False), 100)
        node.create_subscription(
            TFMessage, '/tf_static', lambda message: self.hear(message, True), STATIC
        )

    def hear(self, message: Any, is_static: bool) -> None:
        """Take transforms (tf2_msgs/msg/TFMessage)."""
        for each in message.transforms:
            self._latest[each.child_frame_id] = each, is_static

    def between(self, frame: str, root: str, time: float) -> tuple[Array, Array]:
        """
        Rotation (3, 3) and translation (3,) [m] from a frame to another one.

        Parameters
        ----------
        frame, root : str
            A point p in `frame` is at R p + t in `root`.
        time : float
            Time of the point [s]; 0 if it has none.

        Raises
        ------
        ValueError
            If the frames are not connected, if the quaternion of a transform does not have the
            length 1, or if a transform that changes is too old or too new.

        """
        up, down = self._to_top(frame, time), self._to_top(root, time)
        if up[0] != down[0]:
            why = self.missing or f'no transform connects {up[0]!r} and {down[0]!r}'
            raise ValueError(f'frame {frame!r} is not known in {root!r}: {why}')
        (_, r, t), (_, r0, t0) = up, down
        return r0.T @ r, r0.T @ (t - t0)

    def _to_top(self, frame: str, time: float) -> tuple[str, Array, Array]:
        """Topmost frame above a frame, and the rotation and translation to it."""
        rotation, translation = np.eye(3), np.zeros(3)
        passed = {frame}
        while frame in self._latest:
            step, is_static = self._latest[frame]
            apart = abs(seconds(step.header.stamp) - time)
            if not is_static and time and apart > MAX_APART:
                raise ValueError(
                    f'the transform of {frame!r} must be within {MAX_APART:g} s of the position, '
                    f'got {apart:.3g} s'
                )
            turn = xyzw(step.transform.rotation)
            gate.check_quaternion(f'the rotation of the transform of {frame!r}', turn)
            r = rotation_matrix(np.array(turn) / math.hypot(*turn))
            rotation, translation = r @ rotation, r @ translation + xyz(step.transform.translation)
            frame = step.header.frame_id
            if frame in passed:
                raise ValueError(f'the transforms of {frame!r} form a circle')
            passed.add(frame)
        return frame, rotation, translation
