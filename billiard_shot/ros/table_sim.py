"""The node `table_sim`: a simulated table, whose balls move as the library predicts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from time import monotonic
from typing import Any, ClassVar

from billiard_shot_msgs.msg import BallState, Strike, TableState
from billiard_shot_msgs.srv import PlaceBalls
from geometry_msgs.msg import Point
import numpy as np
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import Header, String
from std_srvs.srv import Trigger

from billiard_shot import predict, Stroke
from billiard_shot.cue.mechanism import Alignment, Mechanism
from billiard_shot.cue.plan import stroke_on_table
from billiard_shot.ros import parameters
from billiard_shot.ros.conversions import check_frame, filled, measured_stroke, requested_scene
from billiard_shot.ros.node_runner import LATCHED, spin_node, steady_timer
from billiard_shot.ros.parameters import guided_scene, OfGuidedScene, OfMechanismFile, OfTable
from billiard_shot.scene import Scene
from billiard_shot.scene.fields import number, whole_number
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.replay import to_json
from billiard_shot.table.model.motion import Motion
from billiard_shot.table.run.results import Trajectory

REST_PERIOD = 0.2
"""Time between two messages on `table_state` while no ball moves [s]."""


@dataclass(frozen=True)
class TableSimParameters(OfTable, OfGuidedScene, OfMechanismFile):
    """
    Parameters of the node.

    Parameters
    ----------
    rate : float
        Rate at which the balls are published [Hz].
    real_time_factor : float
        Speed of the simulation relative to real time.
    camera : bool
        Whether to publish `detections` of a camera instead of table_state; needs vision_msgs.
    seed : int
        Seed of all random numbers.

    """

    READ_ONLY: ClassVar = ('scene', 'mechanism', 'rate', 'real_time_factor', 'camera', 'seed')
    rate: float = number('Hz', minimum=1.0, maximum=1000.0, default=30.0)
    real_time_factor: float = number('', minimum=1e-3, maximum=1e6, default=1.0)
    camera: bool = False
    seed: int = whole_number(minimum=0, maximum=2**31 - 1, default=0)


@dataclass(frozen=True)
class CameraErrors:
    """
    Errors of the simulated camera; parameters that can be set at any time.

    Parameters
    ----------
    detection_noise : float
        Standard deviation of a detected position, in each direction [m].
    detection_loss : float
        Fraction of the detections that are lost.
    detection_swap : float
        Fraction of the pictures in which two balls have the name of the other one.

    """

    detection_noise: float = number('m', minimum=1e-6, maximum=0.1, default=0.0005)
    detection_loss: float = number('', minimum=0.0, maximum=1.0, default=0.0)
    detection_swap: float = number('', minimum=0.0, maximum=1.0, default=0.0)


class TableSim(Node):
    """
    Node that publishes `table_state` (billiard_shot_msgs/msg/TableState), latched.

    At first the balls lie as in the scene. A strike on the topic `cue_driver/strike`
    (billiard_shot_msgs/msg/Strike) sets them in motion, and they stay where they come to rest. A
    strike is ignored while balls still move. If a strike is not solved, the balls stay. Balls that
    have left the table count as pocketed. The state is published at the rate of a camera, and less
    often while nothing moves. With the parameter `camera`, the node publishes `detections`
    (vision_msgs/msg/Detection3DArray) with errors instead, for the node `table_tracker`.
    Every shot is published on `~/shot` (std_msgs/msg/String), latched, as the JSON that
    `billiard_shot.load_shot` reads. The service `~/reset` (std_srvs/srv/Trigger) puts all balls
    back, and `~/place` (billiard_shot_msgs/srv/PlaceBalls) puts balls elsewhere. Its parameters
    are `TableSimParameters`, `CameraErrors` and `Alignment`: where the tip really is beside where
    the encoders say it is. The alignment of the parameter `mechanism` is the one that the driver
    has corrected.
    """

    def __init__(self) -> None:
        super().__init__('table_sim')
        parameters.declare(self, TableSimParameters, CameraErrors, Alignment)
        own = parameters.values_of(TableSimParameters, self)
        self._scene = guided_scene(own.scene)
        self._measured = Mechanism.load(own.mechanism).alignment  # in messages of the driver
        self._real_time_factor = own.real_time_factor
        self._snapshot = 0
        self._motions: Mapping[str, Trajectory] = {}
        self._begin = 0.0
        self._random = np.random.default_rng(own.seed)
        self._is_camera = own.camera
        self._publisher: Publisher[Any]
        if own.camera:
            from vision_msgs.msg import Detection3DArray

            self._publisher = self.create_publisher(Detection3DArray, 'detections', 10)
        else:
            self._publisher = self.create_publisher(TableState, 'table_state', LATCHED)
        self._record = self.create_publisher(String, '~/shot', LATCHED)
        self._put(self._scene)
        steady_timer(self, 1.0 / own.rate, self._see)
        self.create_subscription(Strike, 'cue_driver/strike', self._strike, 10)
        self.create_service(Trigger, '~/reset', self._answer_reset)
        self.create_service(PlaceBalls, '~/place', self._answer_place)
        self.get_logger().info('ready: a simulated table')

    def _put(self, scene: Scene) -> None:
        """Put the balls where a scene has them."""
        self._motions = {}
        radius = scene.ball.radius
        self._balls = {name: (x, y, radius) for name, (x, y) in scene.balls.items()}
        self._balls[CUE_BALL] = scene.cue_ball
        self._gone: set[str] = set()
        self._snapshot += 1
        self._publish()

    def _answer_reset(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._put(self._scene)
        response.success = True
        response.message = f'snapshot {self._snapshot}'
        return response

    def _answer_place(
        self, request: PlaceBalls.Request, response: PlaceBalls.Response
    ) -> PlaceBalls.Response:
        try:
            scene, _ = requested_scene(self._scene, request.balls)
            self._put(scene)
            response.success = True
        except ValueError as error:
            response.message = str(error)
        return response

    def _strike(self, message: Strike) -> None:
        if self._motions:
            self.get_logger().error('ignored a strike: the balls still move')
            return
        places = {name: (x, y) for name, (x, y, _) in self._balls.items()}
        try:
            check_frame('header.frame_id', message.header, self.get_parameter('frame').value)
            scene = replace(self._scene, balls=places)
            stroke = measured_stroke(message, scene.cue_ball)
            alignment = parameters.values_of(Alignment, self)
            if alignment != self._measured:
                place = scene.cue_ball[:2]
                played = stroke_on_table(alignment, stroke, place, scene, self._measured)
                stroke = Stroke.from_offsets(*played.tolist())
        except ValueError as error:
            self.get_logger().error(f'ignored a strike: {error}')
            return
        shot = predict(scene, stroke)
        self.get_logger().info(f'shot {message.shot_id!r}: {shot.status.name}: {shot.message}')
        if not shot.status.refused:
            self._motions = shot.run.balls
            self._begin = monotonic()
            self._record.publish(String(data=to_json(shot)))

    def _see(self) -> None:
        """Move the balls up to now, and publish where they are, as a camera does."""
        if self._motions:
            self._move(self._real_time_factor * (monotonic() - self._begin))
            self._snapshot += 1
        elif not self._is_camera and monotonic() - self._published < REST_PERIOD:
            return
        self._publish()

    def _move(self, time: float) -> None:
        for name, motion in self._motions.items():
            state = motion.at(time)
            x, y, z = state.position.tolist()
            self._balls[name] = x, y, z
            if state.motion in (Motion.POCKETED, Motion.OFF_TABLE):
                self._gone.add(name)
                del self._balls[name]
        if all(time >= motion.duration for motion in self._motions.values()):
            self._motions = {}

    def _publish(self) -> None:
        self._published = monotonic()
        header = parameters.table_header(self)
        if self._is_camera:
            errors = parameters.values_of(CameraErrors, self)
            self._publisher.publish(detections_message(self._balls, errors, self._random, header))
            return
        moving = self._motions.keys()
        balls = [
            BallState(id=name, position=filled(Point, place), moving=name in moving)
            for name, place in self._balls.items()
        ]
        balls += [BallState(id=name, state=BallState.POCKETED) for name in sorted(self._gone)]
        self._publisher.publish(TableState(header=header, snapshot_id=self._snapshot, balls=balls))


def detections_message(
    places: Mapping[str, tuple[float, float, float]],
    errors: CameraErrors,
    random: np.random.Generator,
    header: Header,
) -> Any:
    """
    Make the message of a camera that errs (vision_msgs/msg/Detection3DArray).

    `places` are the centres of the balls [m]; the header has the frame of the table, and the time
    of the picture.
    """
    from vision_msgs.msg import Detection3D, Detection3DArray, ObjectHypothesisWithPose

    labels = list(places)
    if len(labels) > 1 and random.random() < errors.detection_swap:
        i, k = random.choice(len(labels), 2, replace=False)
        labels[i], labels[k] = labels[k], labels[i]
    message = Detection3DArray(header=header)
    for label, place in zip(labels, places.values(), strict=True):
        if random.random() < errors.detection_loss:
            continue
        result = ObjectHypothesisWithPose()
        result.hypothesis.class_id, result.hypothesis.score = label, 1.0
        result.pose.pose.position = filled(
            Point, place + random.normal(0.0, errors.detection_noise, 3)
        )
        result.pose.covariance = (
            errors.detection_noise**2 * np.diag([1.0, 1, 1, 0, 0, 0])
        ).ravel()
        message.detections.append(Detection3D(header=header, results=[result]))
    return message


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    spin_node(TableSim, 'table_sim', args)
