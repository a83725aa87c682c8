"""The node `planner`: searches for strokes that reach a target, and shows the last plan."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
import threading
from time import monotonic
import traceback
from typing import Any
import uuid

from billiard_shot_msgs.action import PlanShot
from billiard_shot_msgs.msg import RankedPlan, TableState
import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node
from rclpy.task import Future
from visualization_msgs.msg import MarkerArray

from billiard_shot import plan, PlanResult, Scene, Status
from billiard_shot.planning.runner import Progress
from billiard_shot.ros import parameters, plan_conversions, table_display
from billiard_shot.ros.node_runner import BURST, GoalHandle, in_thread, LATCHED, spin_node
from billiard_shot.ros.plan_conversions import PlanRequest, target_in
from billiard_shot.scene import Robot
from billiard_shot.scene.fields import number, whole_number

FEEDBACK_PERIOD = 0.1  # s between two feedback messages, or more


@dataclass(frozen=True)
class PlannerParameters(parameters.OfTable, parameters.OfMechanismFile):
    """
    Parameters of the node.

    Parameters
    ----------
    scene : str
        Table, balls until table_state has been received, robot and noise: name of a bundled
        scene, or path of a YAML file.
    mechanism : str
        Path of a YAML file with the mechanism, whose limits hold beside those of the robot. If it
        is empty, only those of the robot hold.
    target : str
        Target of the stroke, if the goal does not give one: a YAML mapping, see
        docs/planning.md.
    budget : int
        Largest number of simulated strokes, if the goal does not give one.
    seconds : float
        Time after which a search ends with its best stroke, if the goal gives neither a time nor a
        budget; 0: none [s].
    seed : int
        Seed of all random numbers, if the goal does not give one.

    """

    scene: str = parameters.checked('paper', Scene.load)
    target: str = parameters.checked('{rest: [0.5, -0.3], radius: 0.1}', target_in)
    budget: int = whole_number(minimum=1, maximum=10_000_000, default=60_000)
    seconds: float = number('s', minimum=0.0, maximum=3600.0, default=1.0)
    seed: int = whole_number(minimum=0, maximum=2**31 - 1, default=1)


class Search:
    """A search for a goal."""

    def __init__(self, goal: GoalHandle, executor: Any) -> None:
        self.ended: Future[None] = Future(executor=executor)
        self.replaced = threading.Event()  # by a newer goal
        self._goal, self._reported, self._next_report = goal, 0, 0.0

    def report(self, now: Progress) -> None:
        """Publish feedback, if there is progress and the last feedback is not quite new."""
        if now.simulations > self._reported and monotonic() >= self._next_report:
            self._reported, self._next_report = now.simulations, monotonic() + FEEDBACK_PERIOD
            feedback = PlanShot.Feedback(simulations=now.simulations, budget=now.budget)
            feedback.success = now.success
            self._goal.publish_feedback(feedback)


class Planner(Node):
    """
    Node with the action `plan_shot` (billiard_shot_msgs/action/PlanShot).

    Each stroke of the result has the plan that the action `execute_shot` plays. Publishes the last
    plan, latched: its best stroke on `~/best` (billiard_shot_msgs/msg/RankedPlan), all of its
    strokes on `~/markers` (visualization_msgs/msg/MarkerArray). Subscribes to `table_state`
    (billiard_shot_msgs/msg/TableState), latched, for goals without positions of the balls. A new
    goal preempts the one that is being planned. Its parameters are `PlannerParameters` and the
    fields of `Robot`.
    """

    def __init__(self) -> None:
        super().__init__('planner')
        parameters.declare(self, PlannerParameters, Robot)
        self.add_post_set_parameters_callback(lambda _: self._configure())
        self._configure()
        self._table: TableState | None = None
        self._search: Search | None = None
        self._best = self.create_publisher(RankedPlan, '~/best', LATCHED)
        self._markers = self.create_publisher(MarkerArray, '~/markers', LATCHED)
        self.create_subscription(TableState, 'table_state', self._keep_table, LATCHED)
        self._server = ActionServer(
            self,
            PlanShot,
            'plan_shot',
            self._execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
            goal_service_qos_profile=BURST,
            result_service_qos_profile=BURST,
            cancel_service_qos_profile=BURST,
        )
        self.get_logger().info(f'ready: action {self.resolve_topic_name("plan_shot")}')

    def _configure(self) -> None:
        """Apply the parameters, which have been checked."""
        own = parameters.values_of(PlannerParameters, self)
        scene, usual = (
            parameters.within_mechanism(Scene.load(own.scene), own.mechanism),
            asdict(Robot()),
        )
        limits = {name: self.get_parameter(name).value for name in usual}
        self._default = PlanRequest(
            scene,
            target_in(own.target),
            scene.noise,
            {name: value for name, value in limits.items() if value != usual[name]},
            own.budget,
            own.seed,
            seconds=own.seconds or None,
        )

    def _keep_table(self, message: TableState) -> None:
        self._table = message

    async def _execute(self, goal: GoalHandle) -> PlanShot.Result:
        try:
            return await self._planned(goal)
        except ValueError as error:
            status = Status.INVALID_REQUEST
            message = plan_conversions.in_fields(str(error), goal.request)
            self.get_logger().warning(f'refused: {message}')
        except Exception as error:  # rclpy would answer with the status 0, which is OK
            status = Status.NO_PLAN
            message = f'the planner failed with {error!r}; its log has the traceback'
            self.get_logger().error(traceback.format_exc())
        goal.abort()
        return PlanShot.Result(status=int(status), message=message)

    async def _planned(self, goal: GoalHandle) -> PlanShot.Result:
        request = plan_conversions.plan_request_of(
            goal.request, self._default, self._table, self.get_parameter('frame').value
        )
        while self._search:  # and all goals that were waiting before this one
            self._search.replaced.set()
            await self._search.ended
        if goal.is_cancel_requested:
            goal.canceled()
            why = 'cancelled before it began'
            return PlanShot.Result(status=int(Status.CANCELLED), message=why)
        search = self._search = Search(goal, self.executor)

        def is_over() -> bool:
            return search.replaced.is_set() or goal.is_cancel_requested or not rclpy.ok()

        try:
            result: PlanResult = await in_thread(
                self,
                lambda: plan(
                    request.scene,
                    request.target,
                    request.noise,
                    request.budget,
                    request.seed,
                    request.constraints,
                    progress=search.report,
                    cancel=is_over,
                    seconds=request.seconds,
                ),
            )
        finally:
            self._search = None
            search.ended.set_result(None)
        self.get_logger().info(f'{result.status.name}: {result.message}')
        header, plan_id = parameters.table_header(self), uuid.uuid4().hex[:8]
        if best := result.best:
            self._best.publish(
                plan_conversions.ranked_message(
                    best, request, f'{plan_id}-1', header, parameters.SHOWN_SAMPLES
                )
            )
            self._markers.publish(table_display.plan_markers(result.ranking, header))
        message = plan_conversions.plan_result(result, request, plan_id, goal.request, header)
        if search.replaced.is_set():
            message.message = f'preempted by a newer goal; {message.message}'
        if goal.is_cancel_requested:
            goal.canceled()
        elif result.status == Status.OK:
            goal.succeed()
        else:
            goal.abort()
        return message


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    spin_node(Planner, 'planner', args)
