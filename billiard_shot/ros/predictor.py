"""The node `predictor`: predicts the shot for a stroke, and shows the last prediction."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
import re
from time import perf_counter
import traceback
from typing import Any

from billiard_shot_msgs.msg import TableState
from billiard_shot_msgs.srv import PredictShot, PredictShots
from nav_msgs.msg import Path
from rclpy.node import Node
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

from billiard_shot import predict, predict_batch, Scene, Shot, Status
from billiard_shot.ros import conversions, parameters, table_display
from billiard_shot.ros.node_runner import BURST, in_thread, LATCHED, spin_node, steady_timer
from billiard_shot.ros.parameters import checked, MAX_SAMPLES, OfTable, SHOWN_SAMPLES
from billiard_shot.scene.fields import number, whole_number
from billiard_shot.shot.replay import to_json

SHOW_DELAY = 0.05  # s from an answer to its path and markers; of several, the last is shown


@dataclass(frozen=True)
class PredictorParameters(OfTable):
    """
    Parameters of the node.

    Parameters
    ----------
    scene : str
        Ball, cue, cloth and impact law: name of a bundled scene, or path of a YAML file.
    tolerance : float
        Largest error of the trajectory on the cloth, if the request does not give one [m].
    sample_count : int
        Samples in the trajectory of an answer, if the request does not give a number. With 0
        there are samples at the start, at changes of motion, and at rest.

    """

    scene: str = checked('paper', Scene.load)
    tolerance: float = number('m', minimum=1e-12, maximum=1.0, default=1e-4)
    sample_count: int = whole_number(minimum=0, maximum=MAX_SAMPLES, default=0)


class Predictor(Node):
    """
    Node with the services `predict_shot` and `predict_shots` (billiard_shot_msgs/srv).

    `predict_shots` predicts many strokes at once. After an answer of `predict_shot`, a timer
    publishes the shot, latched: the cue ball's path on `~/path` (nav_msgs/msg/Path), the cue and
    all moving balls on `~/markers` (visualization_msgs/msg/MarkerArray), and the whole shot on
    `~/shot` (std_msgs/msg/String), as the JSON that `billiard_shot.load_shot` reads. Subscribes to
    `table_state` (billiard_shot_msgs/msg/TableState), latched, for requests with
    `use_table_state`. Its parameters are `PredictorParameters`.
    """

    def __init__(self) -> None:
        super().__init__('predictor')
        parameters.declare(self, PredictorParameters)
        self.add_post_set_parameters_callback(lambda _: self._configure())
        self._configure()
        self._table: TableState | None = None
        self._shown: Shot | None = None

        self._path = self.create_publisher(Path, '~/path', LATCHED)
        self._markers = self.create_publisher(MarkerArray, '~/markers', LATCHED)
        self._record = self.create_publisher(String, '~/shot', LATCHED)
        self._show_timer = steady_timer(self, SHOW_DELAY, self._show, autostart=False)
        self.create_subscription(TableState, 'table_state', self._keep_table, LATCHED)
        self.create_service(PredictShot, 'predict_shot', self._predict_shot, qos_profile=BURST)
        self.create_service(PredictShots, 'predict_shots', self._predict_shots, qos_profile=BURST)
        self.get_logger().info(f'ready: service {self.resolve_service_name("predict_shot")}')

    def _configure(self) -> None:
        """Apply the parameters, which have been checked."""
        self._own = parameters.values_of(PredictorParameters, self)
        self._scene = Scene.load(self._own.scene)

    def _keep_table(self, message: TableState) -> None:
        self._table = message

    async def _predict_shot(
        self, request: PredictShot.Request, response: PredictShot.Response
    ) -> PredictShot.Response:
        own = self._own
        try:
            scene, ball = conversions.place_balls(request, self._scene, self._table, own.frame)
            stroke = conversions.stroke_of(request.cue_pose, request.speed, ball)
            tolerance = request.tolerance or own.tolerance
            work = partial(predict, scene, stroke, tolerance=tolerance, position=ball)
            # a thread takes longer than one ball; a rack of balls that touch takes seconds
            shot = await in_thread(self, work) if len(scene.balls) > 1 else work()
        except Exception as error:
            return _refused(self, response, error)
        samples = request.sample_count or own.sample_count
        response = conversions.response_of(shot, samples, request.all_balls)
        if response.trajectory.times:
            self._shown = shot
            # The executor sends the answer when this callback returns, before it runs the timer.
            # A running timer is not reset, because a stream of requests would delay it forever.
            if self._show_timer.is_canceled():
                self._show_timer.reset()
        return response

    async def _predict_shots(
        self, request: PredictShots.Request, response: PredictShots.Response
    ) -> PredictShots.Response:
        own, begin = self._own, perf_counter()

        def compute() -> PredictShots.Response:
            scene, ball = conversions.place_balls(request, self._scene, self._table, own.frame)
            batch = conversions.requested_batch(request, scene, ball)
            tolerance = request.tolerance or own.tolerance
            result = predict_batch(
                scene, batch.normals, batch.velocities, tolerance, position=ball
            )
            return conversions.batch_response(batch, result, perf_counter() - begin)

        try:
            return await in_thread(self, compute)
        except Exception as error:
            return _refused(self, response, error)

    def _show(self) -> None:
        self._show_timer.cancel()
        shot, header = self._shown, parameters.table_header(self)
        assert shot
        trajectory = conversions.trajectory_message(shot.trajectory, SHOWN_SAMPLES)
        self._path.publish(table_display.path_of(trajectory, header))
        self._markers.publish(table_display.shot_markers(shot, header))
        self._record.publish(String(data=to_json(shot)))


def _refused(node: Node, response: Any, error: Exception) -> Any:
    """Refuse a request because of an error; the library's names become those of the fields."""
    if not isinstance(error, ValueError):  # an answer that never comes is worse than a refusal
        node.get_logger().error(traceback.format_exc())
    response.status = int(getattr(error, 'status', Status.INVALID_REQUEST))
    response.message = re.sub(r'^position\b', 'ball_position', str(error) or repr(error))
    return response


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    spin_node(Predictor, 'predictor', args)
