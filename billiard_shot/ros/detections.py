"""Detections of balls in the messages of a camera, and positions in other frames."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
import math
import re
from typing import Any

from geometry_msgs.msg import TransformStamped
import numpy as np
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from billiard_shot.impact.bodies import rotation_matrix
from billiard_shot.perception import gate
from billiard_shot.perception.tracker import Detection
from billiard_shot.records import Array
from billiard_shot.ros.conversions import seconds, xyz, xyzw
from billiard_shot.scene.errors import must_be
from billiard_shot.scene.placement import CUE_BALL

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


CLASS = re.compile(r'(?:(?P<class_id>[^=*]+)=)?(?P<name>[^=*]+)(?:\*(?P<count>[1-9]\d?))?')
"""A class of detections: its id, if that is not the name of the ball, and the number of balls."""


def class_names_of(entries: Sequence[str]) -> dict[str, str]:
    """Names of balls by class id, from entries such as `8`, `white=cue` and `solid*7`."""
    names = {}
    for entry in entries:
        found = CLASS.fullmatch(entry)
        most = 1 if found and found['name'] == CUE_BALL else gate.MAX_BALLS
        if not found or int(found['count'] or 1) > most:
            allowed = f"such as '8', 'white=cue' or 'solid*7', with at most {most} balls"
            raise ValueError(f'class_names {must_be(allowed, entry)}')
        names[found['class_id'] or found['name']] = found['name']
        gate.check_name('class_names', f'{found["name"]}_{gate.MAX_BALLS}')  # the longest name
    return names


def class_counts_of(entries: Sequence[str], balls: Iterable[str]) -> dict[str, int]:
    """
    Numbers of balls of classes with more than one, by name.

    A number that is not stated is that of the `balls` of a scene, named `solid`, `solid_2`, ...
    """
    counts = Counter(re.sub(r'_\d+$', '', name) for name in balls)
    for found in filter(None, map(CLASS.fullmatch, entries)):
        if found['count']:
            counts[found['name']] = int(found['count'])
    return counts | Counter([CUE_BALL])


def detected_balls(
    detections: Sequence[Any],
    names: Mapping[str, str],
    min_score: float,
    usual_variance: float,
    rotation: Array,
    translation: Array,
) -> tuple[list[Detection], list[str]]:
    """
    Balls of a picture in the frame of the table, and why each other detection is ignored.

    Detections of classes that have no name in `names`, which are by class id, are ignored, and so
    are those that do not pass the gate. If a detection has no covariance, x and y have the
    `usual_variance` [m^2]. More balls than a table can have raise ValueError.
    """
    found, ignored = [], []
    for each in detections:
        best = max(each.results, key=lambda result: result.hypothesis.score, default=None)
        if best is None or not best.hypothesis.score >= min_score:
            continue
        if best.hypothesis.class_id in names:
            found.append((each, best))
        else:
            ignored.append(f'class_id {must_be("in class_names", best.hypothesis.class_id)}')
    gate.check_count('detections of balls', found)
    balls = []
    for each, best in found:
        name, centre = names[best.hypothesis.class_id], best.pose.pose.position
        noise = best.pose.covariance.reshape(6, 6)
        if not noise.any() and xyz(centre) == (0.0, 0.0, 0.0):
            centre = each.bbox.center.position
        with np.errstate(all='ignore'):  # the gate refuses numbers that are not finite
            place = (rotation @ xyz(centre) + translation).tolist()
            turned = (rotation @ noise[:3, :3] @ rotation.T).ravel().tolist()
        try:
            gate.check_position(f'position of {name!r}', place)
            xx, xy, yy = gate.plane_covariance(f'covariance of {name!r}', turned)
        except ValueError as error:
            ignored.append(str(error))
            continue
        if not xx * yy > xy * xy:
            xx, xy, yy = usual_variance, 0.0, usual_variance
        balls.append(Detection(name, (place[0], place[1]), (xx, xy, yy)))
    return balls, ignored
