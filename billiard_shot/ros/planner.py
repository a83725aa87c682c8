"""The node `planner`: searches for strokes that reach a target, and shows the last plan."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
import threading
import traceback
import uuid

from billiard_shot_msgs.action import PlanShot
from billiard_shot_msgs.msg import RankedPlan, TableState
import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.node import Node
from rclpy.task import Future
from visualization_msgs.msg import MarkerArray
import yaml

from billiard_shot import plan, PlanResult, Scene, Status
from billiard_shot.planning.runner import Progress
from billiard_shot.ros import display, parameters, plan_conversions, plan_parameters
from billiard_shot.ros.node_runner import (
    BURST,
    GoalHandle,
    LATCHED,
    log_compilation,
    spin_node,
    steady_timer,
)
from billiard_shot.ros.plan_conversions import PlanRequest
from billiard_shot.scene import Noise, Robot

CANCEL_POLL_PERIOD = 0.02
"""Time between two checks of a search [s]."""

BEST_SAMPLES = 200
"""Number of samples of the trajectory on `~/best`."""

FEEDBACK_PERIOD = 0.1
"""Shortest time between two feedback messages [s]."""


@dataclass(slots=True, eq=False)
class Search:
    """A search that runs in its own thread."""

    request: PlanRequest
    goal: 'GoalHandle | None'  # None: planned at start-up
    ended: 'Future[None] | None'
    stop: threading.Event = field(default_factory=threading.Event)
    preempted: bool = False
    progress: Progress | None = None
    reported: int = 0  # simulations in the last feedback
    result: PlanResult | None = None
    plan_id: str = field(default_factory=lambda: uuid.uuid4().hex[:8])
    trace: str = ''  # of an error in the library
    thread: threading.Thread | None = None

    def begin(self) -> None:
        """Start the thread."""
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _run(self) -> None:
        request = self.request
        try:
            self.result = plan(
                request.scene,
                request.target,
                request.noise,
                request.budget,
                request.seed,
                request.constraints,
                self._on_progress,
                lambda: self.stop.is_set() or not rclpy.ok(),
                time_limit=request.time_limit,
            )
        except ValueError as error:
            self._fail(Status.INVALID_REQUEST, str(error))
        except Exception as error:  # without a result, the status of the answer would be OK
            self.trace = traceback.format_exc()
            self._fail(
                Status.NO_PLAN,
                f'the search failed with {type(error).__name__}: {error}; the log of the planner '
                'has the traceback',
            )

    def _fail(self, status: Status, message: str) -> None:
        self.result = PlanResult(status, message, (), 0, 0.0, self.request.scene.noise)

    def _on_progress(self, progress: Progress) -> None:
        self.progress = progress


class Planner(Node):
    """
    Node with the action `plan_shot` (billiard_shot_msgs/action/PlanShot).

    Each stroke of the result has the plan that the action `execute_shot` plays. Publishes the last
    plan, latched: its best stroke on `~/best`
    (billiard_shot_msgs/msg/RankedPlan), all of its strokes on `~/markers`
    (visualization_msgs/msg/MarkerArray). If `plan_at_start` is true, it plans for its parameter
    `target` at start-up. Subscribes to `table_state` (billiard_shot_msgs/msg/TableState), latched,
    for goals without positions of the balls. A new goal preempts the one that is being planned.
    Its parameters are `plan_parameters.PLANNER`.
    """

    def __init__(self) -> None:
        super().__init__('planner')
        parameters.declare(self, plan_parameters.PLANNER)
        self.add_post_set_parameters_callback(lambda _: self._configure())
        self._configure()
        self._table: TableState | None = None
        self._search: Search | None = None
        self._best = self.create_publisher(RankedPlan, '~/best', LATCHED)
        self._markers = self.create_publisher(MarkerArray, '~/markers', LATCHED)
        self.create_subscription(TableState, 'table_state', self._keep_table, LATCHED)
        self._timer = steady_timer(self, CANCEL_POLL_PERIOD, self._poll, autostart=False)
        self._polls = 0  # since the last feedback
        log_compilation(self)
        warm_up_planning(self._default)
        self._server = ActionServer(
            self,
            PlanShot,
            'plan_shot',
            self._execute,
            cancel_callback=self._cancel,
            goal_service_qos_profile=BURST,
            result_service_qos_profile=BURST,
            cancel_service_qos_profile=BURST,
        )
        self.get_logger().info(f'ready: action {self.resolve_topic_name("plan_shot")}')
        if self.get_parameter('plan_at_start').value:
            self._start(Search(self._default, None, None))

    def _configure(self) -> None:
        """Apply the parameters, which have been checked."""
        scene = Scene.load(self.get_parameter('scene').value)
        limits = {name: self.get_parameter(name).value for name in asdict(Robot())}
        own = asdict(Robot())
        constraints = {name: value for name, value in limits.items() if value != own[name]}
        self._default = PlanRequest(
            scene,
            yaml.safe_load(self.get_parameter('target').value),
            scene.noise.times(self.get_parameter('noise_scale').value),
            constraints,
            self.get_parameter('budget').value,
            self.get_parameter('seed').value,
            self.get_parameter('time_limit').value or None,
        )

    def _keep_table(self, message: TableState) -> None:
        self._table = message

    async def _execute(self, goal: GoalHandle) -> PlanShot.Result:
        try:
            request = plan_conversions.plan_request_of(
                goal.request, self._default, self._table, self.get_parameter('frame').value
            )
        except ValueError as error:
            return self._refuse(goal, str(error))
        while self._search:  # and all goals that were waiting before this one
            self._search.preempted = True
            self._search.stop.set()
            ended = self._search.ended
            if ended is None:
                ended = self._search.ended = Future(executor=self.executor)
            await ended
        if goal.is_cancel_requested:
            goal.canceled()
            return PlanShot.Result(
                status=int(Status.CANCELLED), message='cancelled before it began'
            )
        ended = Future(executor=self.executor)
        search = Search(request, goal, ended)
        self._start(search)
        await ended
        result = search.result
        assert result is not None
        if goal.is_cancel_requested:
            goal.canceled()
        elif result.status == Status.OK:
            goal.succeed()
        else:
            goal.abort()
        message = plan_conversions.plan_result(
            result, request, search.plan_id, goal.request, parameters.table_header(self)
        )
        message.message = plan_conversions.in_fields(message.message, goal.request)
        if search.preempted:
            message.message = f'preempted by a newer goal; {message.message}'
        return message

    def _refuse(self, goal: GoalHandle, why: str) -> PlanShot.Result:
        self.get_logger().warning(f'refused: {why}')
        goal.abort()
        return PlanShot.Result(status=int(Status.INVALID_REQUEST), message=why)

    def _cancel(self, goal: GoalHandle) -> CancelResponse:
        if self._search and self._search.goal is goal:
            self._search.stop.set()
        return CancelResponse.ACCEPT

    def _start(self, search: Search) -> None:
        self._search = search
        search.begin()
        self._timer.reset()

    def _poll(self) -> None:
        """Report the progress of the search; when it has ended, show its result."""
        search = self._search
        if search is None:
            self._timer.cancel()
            return
        if search.thread and search.thread.is_alive():
            self._report(search)
            return
        self._search = None
        self._timer.cancel()
        self._show(search)
        if search.ended:
            search.ended.set_result(None)

    def _report(self, search: Search) -> None:
        self._polls += 1
        now = search.progress
        if (
            search.goal
            and now
            and self._polls * CANCEL_POLL_PERIOD >= FEEDBACK_PERIOD
            and now.simulations > search.reported
        ):
            self._polls, search.reported = 0, now.simulations
            search.goal.publish_feedback(
                PlanShot.Feedback(
                    simulations=now.simulations, budget=now.budget, success=now.success
                )
            )

    def _show(self, search: Search) -> None:
        """Log and publish a plan."""
        result = search.result
        if result is None:
            return
        self.get_logger().info(f'{result.status.name}: {result.message}')
        if search.trace:
            self.get_logger().error(search.trace)
        if result.ranking:
            header = parameters.table_header(self)
            self._best.publish(
                plan_conversions.ranked_message(
                    result, 0, search.request, search.plan_id, header, BEST_SAMPLES
                )
            )
            self._markers.publish(
                display.plan_markers(
                    [each.shot for each in result.ranking],
                    [f'{each.kind}: {each.chance}' for each in result.ranking],
                    header,
                )
            )


def warm_up_planning(request: PlanRequest) -> None:
    """Make small plans, so that the first goal does not have to load the library."""
    table = Scene.load('blocked')
    plan(table, {'pot': '8'}, Noise(), budget=300)
    with suppress(ValueError):  # the planner reports it
        plan(request.scene, request.target, request.noise, 50, request.seed, request.constraints)


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    spin_node(Planner, 'planner', args)


if __name__ == '__main__':
    main()
