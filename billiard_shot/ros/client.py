"""Client of the nodes, and the programs that use it: what they print, and what is typed."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
import gc
import math
import os
import select
import signal
import sys
from time import monotonic
from typing import Any, TextIO
import uuid

from billiard_shot_msgs.action import ExecuteShot, PlanShot
from billiard_shot_msgs.msg import CueState, Plan, TableState, Target
from billiard_shot_msgs.srv import Arm, PredictShot
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from std_msgs.msg import Bool, Header

from billiard_shot import Scene, Stroke
from billiard_shot.cue.plan import GoalOutcome, RefusedError
from billiard_shot.cue.safety import SafetyState
from billiard_shot.perception.sightings import Balls, RestWatch
from billiard_shot.ros import conversions, node_runner
from billiard_shot.scene.errors import printable
from billiard_shot.scene.placement import CUE_BALL

SAFETY_INPUTS = {'estop': False, 'interlock': True}  # topics, and values that allow motion

VALIDITY = 60.0  # s within which a shot must be fired, if the caller does not say
START_UP = 60.0  # s to wait for a node
DISCOVERY = 1.0  # s to discover other publishers before the safety inputs are simulated
LOOK_PERIOD = 0.05  # s between two looks of a client that waits
QUIET_WAIT = 2.0  # s of waiting after which the client logs the reason
REMINDER = 8.0  # s after which it logs that again
ANSWER_TIMEOUT = 30.0  # s in which a node answers, if the machine is busy
PLAN_TIME = 600.0  # s for a plan
UNSEEN_TIME = 5.0  # s without a sight of a ball, while all others rest, until a shot is over
# s in which a node ends a cancelled goal. If the client went on before, the next shot could be
# refused because the driver is busy.
CANCEL_TIME = 10.0


class NotReadyError(RuntimeError):
    """A node, topic or service that is needed is missing or not ready; the message says why."""


class TableUnknownError(NotReadyError):
    """The balls are not known, or do not come to rest; the message says why."""


class CanceledError(RuntimeError):
    """A wait of the client was canceled."""


class RobotClient(Node):
    """
    Node that asks the other nodes and watches the table.

    Parameters
    ----------
    name, namespace : str
        By default the namespace is the one given on the command line.
    simulate_safety_inputs : bool
        Whether to publish that the emergency stop is released and the interlock closed. Only for
        simulations: on a robot these messages come from the safety equipment.
    timeout : float
        Time to wait for each of the other nodes [s].

    Attributes
    ----------
    safety_publishers : dict of str to Publisher
        Publishers of the simulated safety inputs, by topic; empty if they are not simulated.
    is_canceled : bool
        If true, waits end with CanceledError, except those in a block `to_the_end`.

    """

    def __init__(
        self,
        name: str = 'player',
        namespace: str = '',
        simulate_safety_inputs: bool = False,
        timeout: float = START_UP,
    ) -> None:
        super().__init__(name, namespace=namespace)
        self._timeout = timeout
        self._executor = SingleThreadedExecutor()
        self.states: list[CueState] = []
        self.table: TableState | None = None
        self.safety_inputs_on = True
        self.is_canceled = self._goes_on = False
        self.problems = ['no diagnostics']  # of cue_driver
        self._predict: Client[Any, Any] = self.create_client(
            PredictShot, 'predict_shot', qos_profile=node_runner.BURST
        )
        self._arm: Client[Any, Any] = self.create_client(Arm, 'cue_driver/arm')
        self._plan: ActionClient[Any, Any, Any] = ActionClient(self, PlanShot, 'plan_shot')
        self.execute_shot: ActionClient[Any, Any, Any] = ActionClient(
            self, ExecuteShot, 'execute_shot'
        )
        self.create_subscription(TableState, 'table_state', self._on_table, node_runner.LATCHED)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)
        self.create_subscription(
            CueState, 'cue_driver/state', self.states.append, node_runner.EVERY_STATE
        )
        self.safety_publishers: dict[str, Publisher[Bool]] = {}
        self._discovered = monotonic() + DISCOVERY
        if simulate_safety_inputs:
            self.get_logger().warning(
                'simulating the emergency stop and the interlock: never do this on a robot'
            )
            self.safety_publishers = {
                name: self.create_publisher(Bool, name, 10) for name in SAFETY_INPUTS
            }
            self.create_timer(LOOK_PERIOD, self._publish_safety_inputs)

    def _publish_safety_inputs(self) -> None:
        own = self.get_name(), self.get_namespace()
        for name in SAFETY_INPUTS:
            for other in self.get_publishers_info_by_topic(self.resolve_topic_name(name)):
                if other.node_name == node_runner.UNKNOWN_NODE:
                    return  # it may be this node; a later call finds its name
                if (other.node_name, other.node_namespace) != own:
                    raise NotReadyError(
                        f'node {other.node_name!r} publishes {name!r}: this cell has safety '
                        'equipment, so the safety inputs must not be simulated'
                    )
        if self.safety_inputs_on and monotonic() > self._discovered:
            for name, value in SAFETY_INPUTS.items():
                self.safety_publishers[name].publish(Bool(data=value))

    def _on_table(self, message: TableState) -> None:
        self.table = message

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == self.resolve_topic_name('cue_driver'):
                self.problems = [
                    printable(f'{each.key}: {each.value}')
                    for each in status.values
                    if each.key not in ('shot_id', 'alignment') and each.value != 'ok'
                ]

    # --- waiting --------------------------------------------------------------------------------

    def until(self, condition: Callable[[], object], seconds: float) -> bool:
        """Spin until a condition holds; return False if it does not within `seconds`."""
        deadline = monotonic() + seconds
        # `rclpy.spin_once(self)` would add and remove the node each time, which ends the next wait
        # at once: while a goal awaits its result, that is a busy loop.
        self._executor.add_node(self)
        while not condition():
            if self.is_canceled and not self._goes_on:
                raise CanceledError('canceled')
            if monotonic() > deadline:
                return False
            self._executor.spin_once(timeout_sec=LOOK_PERIOD)
        return True

    def destroy_node(self) -> None:
        """Destroy the node, and what its last wait holds."""
        self._executor.shutdown()
        super().destroy_node()

    @contextmanager
    def to_the_end(self) -> Iterator[None]:
        """Do not end waits in the block if the client is canceled."""
        before, self._goes_on = self._goes_on, True
        try:
            yield
        finally:
            self._goes_on = before

    def wait_for_predictor(self) -> None:
        """Wait for the predictor; NotReadyError says why it is not ready."""
        self.wait_for('predictor', self._predict.service_is_ready)

    def wait_for_planner(self) -> None:
        """Wait for the planner; NotReadyError says why it is not ready."""
        self.wait_for('planner', self._plan.server_is_ready)

    def wait_for_table(self) -> None:
        """Wait for a table state; NotReadyError if none is received."""
        self.wait_for('table_state', lambda: self.table)

    def wait_for_all(self) -> None:
        """Wait for everything that a shot needs; NotReadyError says what is missing, and why."""
        self.wait_for_predictor()
        self.wait_for_driver()

    def wait_for_driver(self) -> None:
        """Wait until the driver can play; NotReadyError says what is missing, and why."""
        servers = self._arm.service_is_ready, self.execute_shot.server_is_ready
        self.wait_for('cue_driver', lambda: self.states and all(each() for each in servers))
        self.wait_for_table()
        if self.safety_publishers:  # else a shot could end before safety equipment is discovered
            self.until(lambda: monotonic() > self._discovered, DISCOVERY)
        self.problems = ['no diagnostics']
        self.wait_for('cue_driver', lambda: not self.problems)

    def wait_for(self, name: str, ready: Callable[[], object]) -> None:
        """Spin until a node or topic is `ready`, and log why it is not; NotReadyError says why."""
        end, silence = monotonic() + self._timeout, QUIET_WAIT
        while not self.until(ready, min(silence, end - monotonic())):
            words = f'{self.resolve_topic_name(name)}: {self._reason(name)}'
            if monotonic() > end:
                raise NotReadyError(f'{words}; waited for {self._timeout:g} s')
            self.get_logger().info(f'waiting for {words}')
            silence = REMINDER

    def _reason(self, node: str) -> str:
        """Why a node or a topic is not ready, as far as this node can tell."""
        if node == 'table_state':
            return 'no message received'
        path = self.resolve_topic_name(node)
        if (node, path.rpartition('/')[0] or '/') not in self.get_node_names_and_namespaces():
            return 'no such node is known so far'
        if node == 'cue_driver' and self.problems:
            return '; '.join(self.problems)
        return 'the node is starting'

    # --- the table ------------------------------------------------------------------------------

    def balls(self) -> Balls:
        """Return the balls that are not pocketed, as the last table state has them."""
        table = self.known_table()
        try:
            return conversions.sightings_of(table.balls, table.header.stamp)
        except ValueError as error:
            raise TableUnknownError(f'table_state: {error}') from None

    def known_table(self) -> TableState:
        """Last table state; NotReadyError if none has been received."""
        if self.table is None:
            raise TableUnknownError('table_state: no message received')
        return self.table

    def wait_for_rest(
        self, strike: Time | None = None, seconds: float = 60.0, unseen_time: float = math.inf
    ) -> Balls:
        """
        Wait until all balls rest, and return those on the table.

        Detections from before the strike are ignored, because a camera or simulation without
        enough processor time shows the earlier positions for a while. Balls that are not seen are
        returned, too, once all others have rested for `unseen_time` [s]. If no newer table state
        is received, or a ball moves on or is not seen, TableUnknownError says so.
        """
        deadline = monotonic() + seconds
        watch = RestWatch()
        while True:
            balls = self.balls()
            why = self._early(balls, strike) or watch.restless(balls, monotonic(), unseen_time)
            if not why:
                return balls
            if monotonic() > deadline:
                raise TableUnknownError(f'table_state: {why} after {seconds:g} s')
            self.until(lambda: False, LOOK_PERIOD)

    def _early(self, balls: Balls, strike: Time | None) -> str:
        """Say which part of the table state was seen before a strike; '' if none was."""
        if strike is None:
            return ''
        times = {'the picture': conversions.seconds(self.known_table().header.stamp)}
        times |= {f'ball {name!r}': ball.time for name, ball in balls.items() if ball.is_seen}
        for name, time in times.items():
            if 0.0 < time <= conversions.seconds(strike):
                return f'{name} is from before the strike'
        return ''

    # --- requests -------------------------------------------------------------------------------

    def predict(self, request: PredictShot.Request) -> PredictShot.Response:
        """Call the predictor."""
        return self.call(self._predict, request, attempts=15)

    def plan(self, target: Target, budget: int = 0) -> Any:
        """Plan for a target and the current balls; return the status and result of the goal."""
        request = PlanShot.Goal(target=target, balls=self.known_table().balls, budget=budget)
        with self.acting('plan_shot', self._plan, request) as answer:
            self.until(answer, PLAN_TIME)
        if not (ended := answer()):
            raise NotReadyError(f'action plan_shot: no plan within {PLAN_TIME:g} s')
        return ended

    def goal(
        self, stroke: Stroke, balls: Balls, scene: Scene, name: str, valid_for: float = VALIDITY
    ) -> ExecuteShot.Goal:
        """
        Make a goal for a stroke that somebody has chosen for these balls, not for later ones.

        The id of the shot is new, and begins with `name`. RefusedError says so if the cue ball is
        not on the table.
        """
        if CUE_BALL not in balls:
            raise RefusedError(
                GoalOutcome.INVALID_PLAN, f'there is no ball {CUE_BALL!r} on the table'
            )
        shot_id = f'{name} {uuid.uuid4().hex[:8]}'  # the driver plays each id once
        command = scene.noise.commanded(stroke, scene.ball.radius)
        plan = conversions.plan_of(command, balls, scene, shot_id)
        frame = self.known_table().header.frame_id
        header = Header(frame_id=frame, stamp=self.get_clock().now().to_msg())
        return self.goal_to_play(conversions.plan_message(plan, header), valid_for)

    def goal_to_play(self, plan: Plan, valid_for: float = VALIDITY) -> ExecuteShot.Goal:
        """Make a goal to play a plan within `valid_for` [s] from now."""
        expiry = self.get_clock().now() + Duration(nanoseconds=round(1e9 * valid_for))
        return ExecuteShot.Goal(plan=plan, expiry=expiry.to_msg())

    def execute(
        self,
        goal: ExecuteShot.Goal,
        may_fire: Callable[[], bool] = lambda: True,
        on_aimed: Callable[[], object] = lambda: None,
    ) -> Any:
        """
        Send a goal, and return its status and result when it has ended.

        While the cue is aimed, `may_fire` is called again and again; once it is true, the shot is
        armed. `on_aimed` is called once before that. If arming is refused, or this call is
        interrupted, for example by Ctrl+C, the goal is cancelled; the message of the result has
        the refusal. If the client is canceled, it raises CanceledError, unless the cue has struck.
        If the driver has ended or does not answer, it raises NotReadyError.
        """
        now = 1e-9 * self.get_clock().now().nanoseconds
        left = conversions.seconds(goal.expiry) - now + 60.0
        canceled: CanceledError | None = None
        refusal = ''  # of arming

        def waits(ready: Callable[[], object]) -> bool:
            return self.until(lambda: answer() or ready(), left) and not answer()

        with self.acting('execute_shot', self.execute_shot, goal) as answer:
            try:
                if waits(lambda: self._is_aimed(goal)):
                    on_aimed()
                    if waits(may_fire):
                        armed = self.arm(goal.plan.shot_id)
                        if waits(lambda: armed.done() and not result_of(armed).success):
                            refusal = f'; not armed: {result_of(armed).message}'
            except CanceledError as error:
                canceled = error
        ended = answer()
        if canceled and not (ended and ended.result.struck):
            raise canceled
        if not ended:
            raise NotReadyError('action execute_shot does not end')
        ended.result.message += refusal
        return ended

    def arm(self, shot_id: str) -> 'Future[Any]':
        """Arm the aimed shot; return the future of the answer, and log it if it is refused."""
        armed = self._arm.call_async(Arm.Request(shot_id=shot_id))

        def log(done: 'Future[Any]') -> None:
            if not result_of(done).success:
                self.get_logger().error(f'not armed: {printable(result_of(done).message)}')

        armed.add_done_callback(log)
        return armed

    def call(self, client: 'Client[Any, Any]', request: Any, attempts: int = 1) -> Any:
        """
        Call a service, and return its answer; if it does not answer, NotReadyError.

        The answer is lost if the server has not yet discovered the client, even if the client has
        discovered the server (github.com/ros2/rmw_fastrtps/issues/842). A request that may be
        executed twice may have several `attempts`.
        """
        for _ in range(attempts):
            sent = client.call_async(request)
            if self.until(sent.done, ANSWER_TIMEOUT / attempts):
                return result_of(sent)
            client.remove_pending_request(sent)
        raise NotReadyError(f'no answer from {client.service_name} within {ANSWER_TIMEOUT:g} s')

    @contextmanager
    def acting(
        self,
        name: str,
        action: 'ActionClient[Any, Any, Any]',
        goal: Any,
    ) -> Iterator[Callable[[], Any]]:
        """
        Send a goal of an action.

        The block gets a function that returns the status and the result of the goal; None until
        the goal has ended; NotReadyError if the node of the action has ended. If the goal has not
        ended at the end of the block, it is cancelled, and may take `CANCEL_TIME` to end.
        """
        servers: set[bytes] = set()

        def answer() -> Any:
            if ended is None or ended.done():
                return ended and result_of(ended)
            topic = f'{name}/_action/status'
            now = {bytes(each.endpoint_gid) for each in self.get_publishers_info_by_topic(topic)}
            if not servers:
                servers.update(now)
            elif not servers & now:  # of a node that was killed before, one may stay for a while
                raise NotReadyError(f'action {name}: its node has ended, and with it the goal')
            return None

        sent, ended = action.send_goal_async(goal), None
        try:
            if not self.until(sent.done, ANSWER_TIMEOUT):
                raise NotReadyError(f'no answer from action {name} within {ANSWER_TIMEOUT:g} s')
            handle = result_of(sent)
            if not handle.accepted:
                drives = action is self.execute_shot
                why = self._reason('cue_driver') if drives else 'another goal is carried out'
                raise NotReadyError(f'action {name} rejects the goal: {why}')
            ended = handle.get_result_async()
            yield answer
        finally:
            with self.to_the_end(), suppress(NotReadyError):
                # an interruption may come before the answer to the goal
                if ended is None and self.until(sent.done, CANCEL_TIME):
                    handle = result_of(sent)
                    ended = handle.get_result_async() if handle.accepted else None
                if ended is not None and not ended.done():
                    handle.cancel_goal_async()
                    self.until(answer, CANCEL_TIME)

    def _is_aimed(self, goal: ExecuteShot.Goal) -> bool:
        aimed = SafetyState.AIMED, goal.plan.shot_id
        return any((last.state, last.shot_id) == aimed for last in self.states[-1:])


def result_of(future: 'Future[Any]') -> Any:
    """Return the result of a future that is done."""
    result = future.result()
    assert result is not None
    return result


FIRE = 'fire'  # what the operator types to fire an aimed shot


def escaped(text: str) -> str:
    """Escape characters that a terminal would obey, except ends of lines."""
    return '\n'.join(map(printable, text.split('\n')))


def say(text: str, file: TextIO | None = None) -> None:
    """Print lines at once, escaped."""
    print(escaped(text), file=file, flush=True)


class TypedLines:
    """Lines that somebody types, while the program goes on."""

    def __init__(self) -> None:
        self._typed = b''

    def next(self) -> str | None:
        """Return the next line without spaces at its ends; None if there is none yet."""
        if b'\n' not in self._typed and select.select([sys.stdin], [], [], 0.0)[0]:
            self._typed += os.read(sys.stdin.fileno(), 4096)
        line, end, rest = self._typed.partition(b'\n')
        if not end:
            return None
        self._typed = rest
        return line.decode(errors='replace').strip()


PLAYED, SHOT_FAILED, NOT_READY = 0, 1, 3  # exit codes; argparse ends with 2

CLIENT_HELP = """\
exit codes:
  0  every shot was played, and reached its target if it has one; a turn was played, and the
     rack was not lost; with --serve, after Ctrl+C or SIGTERM
  1  a shot was refused, ended early, or missed its target; the output says why; later
     shots are not played
  2  the arguments are invalid
  3  a node is missing or not ready; the message names it
  130, 143  ended by Ctrl+C or SIGTERM; a shot that has not begun is cancelled

ROS arguments follow --ros-args, such as -r __ns:=/left_robot"""
"""End of the help of programs that ask the nodes."""


@dataclass(frozen=True)
class OfClient:
    """
    The scene, and how long to wait.

    Parameters
    ----------
    scene : SCENE
        Bundled scene or YAML file, for given strokes; the same as for the nodes (%(default)s).
    wait : S
        Time to wait for each node in seconds (%(default)g).

    """

    scene: str = 'paper'
    wait: float = START_UP


def run_client(
    name: str,
    args: Sequence[str] | None,
    work: Callable[[RobotClient], bool],
    *,
    serves: bool = False,
    **options: Any,
) -> None:
    """
    Do some work with a client, and exit with one of the codes of `CLIENT_HELP`.

    A client that `serves` is the node `name`, which ends with 0 after a signal. Another one is
    canceled by a signal, and ends by a second one. `options` are parameters of `RobotClient`.
    """
    caught: list[int] = []

    # A signal handler that raises SystemExit would sometimes do so within rclpy, which drops the
    # exception. So a timer looks between two callbacks.
    def end_if_caught() -> None:
        if len(caught) > (not serves):
            sys.exit(0 if serves else 128 + caught[0])
        client.is_canceled |= bool(caught)

    # The handlers of rclpy would shut down its context, and then no goal could be cancelled.
    with node_runner.initialized(args, signal_handler_options=SignalHandlerOptions.NO):
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda number, _: caught.append(number))
        try:
            client = RobotClient(name if serves else f'{name}_client', **options)
            node_runner.steady_timer(client, LOOK_PERIOD, end_if_caught)
            gc.freeze()  # a long garbage collection would silence the safety inputs
            code = PLAYED if work(client) else SHOT_FAILED
        except NotReadyError as error:
            say(f'{name}: {error}', sys.stderr)
            code = NOT_READY
        except CanceledError:
            pass
    sys.exit(128 + caught[0] if caught else code)
