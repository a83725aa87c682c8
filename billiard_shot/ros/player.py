"""
Play strokes with the mechanical cue: predict, execute, and compare the final cue-ball position.

    ros2 run billiard_shot player --b 0.3 --speed 0.5

Needs a predictor, an active cue_driver, a mechanism, and a node that publishes table_state.
"""

import argparse
from collections.abc import Callable, Iterable, Sequence
import gc
import math
import signal
import sys
from time import monotonic
from typing import Any, TYPE_CHECKING, TypeVar
import uuid

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import CueState, Plan, TableState
from billiard_shot_msgs.srv import Arm, PredictShot
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from numpy.typing import NDArray
import rclpy
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args
from std_msgs.msg import Bool, Header

from billiard_shot import Scene, Status, Stroke
from billiard_shot.cue.outcome import Outcome, RefusedError
from billiard_shot.cue.safety import State
from billiard_shot.cue.sightings import Balls
from billiard_shot.ros import conversions, cue_conversions
from billiard_shot.ros.client import result_of, ServiceCaller, START_UP
from billiard_shot.ros.node_runner import EVERY_STATE, initialized, LATCHED, steady_timer
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.stroke_options import add_stroke_arguments, strokes_of

if TYPE_CHECKING:
    from rclpy.client import Client
    from rclpy.publisher import Publisher

SAFETY_PERIOD = 0.05
"""Time between two messages of the simulated safety inputs [s]."""

DISCOVERY = 1.0
"""Time for discovering other publishers before the safety inputs are simulated [s]."""

SAFETY_INPUTS = {'estop': False, 'interlock': True}
"""Topics of the safety inputs, and the values that allow motion."""

QUIET_WAIT = 2.0
"""Time [s] after which the player logs the service, topic or action that it waits for."""

ANSWER_TIME = 30.0
"""Longest time in which a node answers, if the machine is busy [s]."""

SIGNAL_PERIOD = 0.05
"""Time between two checks for caught signals [s]."""

REMINDER = 8.0
"""Time between two messages in the log about the same wait [s]."""

REST_DISTANCE = 1e-3
"""A ball that moves less than this [m] within `REST_TIME` is at rest."""

REST_TIME = 0.5
"""Time in which a ball at rest moves less than `REST_DISTANCE` [s]."""

DEFAULT_VALIDITY, MAX_VALIDITY = 60.0, 3600.0
"""Default and longest time within which a shot must be fired [s]."""

PLAYED, FAILED, NOT_READY = 0, 1, 3
"""Exit codes; argparse ends with 2."""

EXIT_CODES = """\
exit codes:
  0  every shot was played, and reached its target if it has one
  1  a shot was refused, ended early, or missed its target; the output says why; later
     shots are not played
  2  the arguments are invalid
  3  a node is missing or not ready; the message names it
  130, 143  ended by Ctrl+C or SIGTERM; a shot that has not begun is cancelled
"""

P = TypeVar('P', bound='Player')
R = TypeVar('R')


class NotReadyError(RuntimeError):
    """A node, topic or service that a shot needs is missing or not ready."""


class Player(Node):
    """
    Node that plays shots and monitors the table.

    Parameters
    ----------
    namespace : str
        Namespace of the node; '' for the one given on the command line.
    simulate_safety_inputs : bool
        Whether to publish that the emergency stop is released and the interlock closed. Only for
        simulations: on a robot these messages come from the safety equipment.
    timeout : float
        Time to wait for each of the other nodes [s].

    """

    def __init__(
        self,
        namespace: str = '',
        simulate_safety_inputs: bool = False,
        timeout: float = START_UP,
    ) -> None:
        super().__init__('player', namespace=namespace)
        self._timeout = timeout
        self.states: list[CueState] = []
        self.table: TableState | None = None
        self.safety_inputs_on = True
        self.problems: list[str] = []
        self._predict = ServiceCaller(self, PredictShot, 'predict_shot')
        self._arm: Client[Any, Any] = self.create_client(Arm, 'cue_driver/arm')
        self.execute_shot: ActionClient[Any, Any, Any] = ActionClient(
            self, ExecuteShot, 'execute_shot'
        )
        self.create_subscription(TableState, 'table_state', self._on_table, LATCHED)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._on_diagnostics, 10)
        self.create_subscription(CueState, 'cue_driver/state', self.states.append, EVERY_STATE)
        self._safety: dict[str, Publisher[Bool]] = {}
        self._discovered = monotonic() + DISCOVERY
        if simulate_safety_inputs:
            self.get_logger().warning(
                'simulating the emergency stop and the interlock: never do this on a robot'
            )
            self._safety = {name: self.create_publisher(Bool, name, 10) for name in SAFETY_INPUTS}
            self.create_timer(SAFETY_PERIOD, self._publish_safety_inputs)

    def _publish_safety_inputs(self) -> None:
        for name in SAFETY_INPUTS:
            for other in self.get_publishers_info_by_topic(self.resolve_topic_name(name)):
                if (other.node_name, other.node_namespace) != (
                    self.get_name(),
                    self.get_namespace(),
                ):
                    raise NotReadyError(
                        f'node {other.node_name!r} publishes {name!r}: this cell has safety '
                        'equipment, so the safety inputs must not be simulated'
                    )
        if self.safety_inputs_on and monotonic() > self._discovered:
            for name, value in SAFETY_INPUTS.items():
                self._safety[name].publish(Bool(data=value))

    def _on_table(self, message: TableState) -> None:
        self.table = message

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == self.resolve_topic_name('cue_driver'):
                self.problems = [
                    f'{each.key}: {each.value}'
                    for each in status.values
                    if each.key != 'shot_id' and each.value != 'ok'
                ]

    def exit_on(self, signals: list[int]) -> None:
        """Exit as soon as there is a signal in the list, between two callbacks."""

        # A signal handler that raises SystemExit would sometimes do so within rclpy, which drops
        # the exception.
        def look() -> None:
            if signals:
                sys.exit(128 + signals.pop())

        steady_timer(self, SIGNAL_PERIOD, look)

    def until(self, condition: Callable[[], object], seconds: float) -> bool:
        """Spin until a condition holds; return False if it does not within `seconds`."""
        deadline = monotonic() + seconds
        while not condition():
            if monotonic() > deadline:
                return False
            rclpy.spin_once(self, timeout_sec=0.05)
        return True

    def wait_for_all(self) -> None:
        """Wait for everything that a shot needs; NotReadyError names what is missing."""
        needs: tuple[tuple[str, str, Callable[[], object]], ...] = (
            ('service', 'predict_shot', self._predict.service_is_ready),
            ('service', 'cue_driver/arm', self._arm.service_is_ready),
            ('action', 'execute_shot', self.execute_shot.server_is_ready),
            ('topic', 'table_state', lambda: self.table),
            ('topic', 'cue_driver/state', lambda: self.states),
        )
        for need in needs:
            self.wait_for(*need)
        if self._safety:  # otherwise a shot could end before safety equipment is discovered
            self.until(lambda: monotonic() > self._discovered, DISCOVERY)
        self.problems = ['no diagnostics']
        if not self._until(lambda: not self.problems, 'waiting for cue_driver', self._timeout):
            raise NotReadyError(f'cue_driver is not ready: {"; ".join(self.problems)}')

    def wait_for(self, kind: str, name: str, found: Callable[[], object]) -> None:
        """Wait for a service, action or topic; log if it is not found soon."""
        name = f'{kind} {self.resolve_topic_name(name)}'
        if not self._until(found, f'waiting for {name}', self._timeout):
            raise NotReadyError(f'no {name} within {self._timeout:g} s')

    def _until(self, condition: Callable[[], object], words: str, seconds: float) -> bool:
        """Spin as in `until`; log `words` after `QUIET_WAIT`, then after every `REMINDER`."""
        deadline, silence = monotonic() + seconds, QUIET_WAIT
        while not self.until(condition, min(silence, deadline - monotonic())):
            if monotonic() > deadline:
                return False
            self.get_logger().info(words)
            silence = REMINDER
        return True

    def balls(self) -> Balls:
        """Return the balls that are not pocketed, as the last table state has them."""
        table = self.known_table()
        try:
            return conversions.sightings_of(table.balls, table.header.stamp)
        except ValueError as error:
            raise NotReadyError(f'table_state: {error}') from None

    def known_table(self) -> TableState:
        """Last table state; NotReadyError if none has been received."""
        if self.table is None:
            raise NotReadyError('table_state: no message received')
        return self.table

    def goal(
        self, stroke: Stroke, scene: Scene, shot_id: str, valid_for: float = DEFAULT_VALIDITY
    ) -> ExecuteShot.Goal:
        """
        Make a goal for a stroke at the cue ball, at its current position.

        Raises
        ------
        RefusedError
            If the cue ball is not on the table.

        """
        balls = self.balls()
        if CUE_BALL not in balls:
            raise RefusedError(
                Outcome.INVALID_PLAN, f'table_state has no ball {CUE_BALL!r} on the table'
            )
        plan = cue_conversions.plan_of(stroke, balls, scene, shot_id)
        frame = self.known_table().header.frame_id
        header = Header(frame_id=frame, stamp=self.get_clock().now().to_msg())
        return self.goal_to_play(cue_conversions.plan_message(plan, header), valid_for)

    def goal_to_play(self, plan: Plan, valid_for: float = DEFAULT_VALIDITY) -> ExecuteShot.Goal:
        """Make a goal to play a plan within `valid_for` [s] from now."""
        expiry = self.get_clock().now() + Duration(nanoseconds=round(1e9 * valid_for))
        return ExecuteShot.Goal(plan=plan, expiry=expiry.to_msg())

    def predict(self, goal: ExecuteShot.Goal) -> PredictShot.Response:
        """Call the predictor for the planned stroke."""
        request = PredictShot.Request(
            cue_pose=goal.plan.cue_pose, speed=goal.plan.speed, use_table_state=True
        )
        return self._predict.call(request, repeatable=True)

    def execute(
        self,
        goal: ExecuteShot.Goal,
        arm: bool = True,
        on_aimed: Callable[[], None] = lambda: None,
    ) -> Any:
        """
        Send a goal, and return its status and result when it has ended.

        If this call is interrupted, for example by Ctrl+C, the goal is cancelled.

        Parameters
        ----------
        goal
        arm : bool
            Whether to arm the cue as soon as it is aimed; otherwise the operator has to arm it.
        on_aimed : callable
            Called when the cue is aimed and waits to be armed.

        """
        ended = self.act(
            'execute_shot',
            self.execute_shot,
            goal,
            lambda ended: self._wait_for_end(goal, ended, arm, on_aimed),
        )
        if ended is None:
            raise NotReadyError('action execute_shot does not end')
        return ended

    def act(
        self,
        name: str,
        action: 'ActionClient[Any, Any, Any]',
        goal: Any,
        wait: Callable[[Any], object],
    ) -> Any:
        """
        Send a goal of an action, and return its status and result; None if it does not end.

        `wait` waits for the future of the result. If the goal has not ended after that, or the
        wait is interrupted, it is cancelled.
        """
        sent = action.send_goal_async(goal)
        if not self.until(sent.done, ANSWER_TIME):
            raise NotReadyError(f'no answer from action {name} within {ANSWER_TIME:g} s')
        handle = result_of(sent)
        ended = handle.get_result_async()
        try:
            wait(ended)
        finally:
            if not ended.done():
                handle.cancel_goal_async()
                self.until(ended.done, 2.0)
        return result_of(ended) if ended.done() else None

    def _wait_for_end(
        self, goal: ExecuteShot.Goal, ended: Any, arm: bool, on_aimed: Callable[[], None]
    ) -> None:
        now = self.get_clock().now().nanoseconds
        left = goal.expiry.sec + 1e-9 * (goal.expiry.nanosec - now) + 60.0
        if self.until(lambda: ended.done() or self._is_aimed(goal), left) and not ended.done():
            on_aimed()
            if arm:
                answer = self._arm.call_async(Arm.Request(shot_id=goal.plan.shot_id))
                self.until(lambda: answer.done() or ended.done(), ANSWER_TIME)
                if answer.done() and not result_of(answer).success:
                    self.get_logger().error(f'not armed: {result_of(answer).message}')
                    return
        self.until(ended.done, left)

    def _is_aimed(self, goal: ExecuteShot.Goal) -> bool:
        last = self.states[-1]
        return last.state == State.AIMED and last.shot_id == goal.plan.shot_id

    def wait_for_rest(
        self, strike: Time | None = None, seconds: float = 60.0
    ) -> NDArray[np.float64] | None:
        """
        Wait until the cue ball rests, and return (x, y) [m]; None if it moves on or is pocketed.

        Table states older than the stamp of the strike are ignored, because a camera or simulation
        without enough processor time shows the earlier positions for a while. Raises NotReadyError
        if no newer table state is received.
        """
        deadline = monotonic() + seconds
        if strike and not self.until(
            lambda: _is_after(self.known_table().header.stamp, strike), seconds
        ):
            raise NotReadyError(f'table_state: no message after the strike within {seconds:g} s')
        last, since = (math.inf, math.inf), monotonic()
        while monotonic() < deadline:
            rclpy.spin_once(self, timeout_sec=0.05)
            ball = self.balls().get(CUE_BALL)
            if ball is None:
                return None
            place = ball.position
            if not math.dist(place, last) <= REST_DISTANCE:
                last, since = place, monotonic()
            elif monotonic() - since > REST_TIME:
                return np.array(place)
        return None


def short_id() -> str:
    """Make a unique name."""
    return uuid.uuid4().hex[:8]


def _is_after(stamp: Time, strike: Time) -> bool:
    """Whether a table state was seen after a strike; true if the table state has no stamp."""
    seen = conversions.seconds(stamp)
    return seen == 0.0 or seen > conversions.seconds(strike)


def play_shot(player: Player, name: str, goal: ExecuteShot.Goal, arm: bool) -> bool:
    """Play one shot and print its prediction and outcome; return False if it was not played."""
    answer = player.predict(goal)
    status = Status(answer.status)
    print(
        f'{name}: {goal.plan.speed:g} m/s, elevation {goal.plan.elevation + 0.0:g} rad', flush=True
    )
    if status.refused:
        print(f'  predicted   {status.name}: {answer.message}')
        return False
    expected = conversions.vectors(answer.trajectory.positions)[-1][:2]

    def tell_how_to_arm() -> None:
        if not arm:
            service = player.resolve_service_name('cue_driver/arm')
            print(
                f'  aimed       to fire: ros2 service call {service} billiard_shot_msgs/srv/Arm '
                f'"{{shot_id: {goal.plan.shot_id}}}"',
                flush=True,
            )

    response = player.execute(goal, arm, tell_how_to_arm)
    result = response.result
    print(f'  executed    {Outcome(result.outcome).name}: {result.message}')
    if response.status != GoalStatus.STATUS_SUCCEEDED:
        return False
    speed = result.strike.speed
    print(
        f'  measured    {speed:.4f} m/s ({100 * (speed / goal.plan.speed - 1):+.3f} %), '
        f'elevation {result.elevation:.5f} rad\n'
        f'  predicted   rests at ({expected[0]:.4f}, {expected[1]:.4f}) m',
        flush=True,
    )
    rest = player.wait_for_rest(result.strike.header.stamp)
    if rest is None:
        print('  outcome     the cue ball does not rest on the table', flush=True)
    else:
        print(
            f'  outcome     rests at ({rest[0]:.4f}, {rest[1]:.4f}) m, '
            f'{1e3 * np.hypot(*(rest - expected)):.2f} mm from the prediction',
            flush=True,
        )
    return True


def add_player_arguments(parser: argparse.ArgumentParser, scene: bool) -> None:
    """Add the options of both players; `scene` adds the option of the scene."""
    if scene:
        parser.add_argument(
            '--scene',
            default='paper',
            metavar='SCENE',
            help='bundled scene or YAML file; the same as for the cue_driver (paper)',
        )
    parser.add_argument(
        '--arm',
        action='store_true',
        help='arm each shot as soon as it is aimed; otherwise wait for a call of the service '
        'cue_driver/arm',
    )
    parser.add_argument(
        '--wait',
        type=float,
        default=START_UP,
        metavar='S',
        help=f'time to wait for each node in seconds ({START_UP:g})',
    )
    parser.add_argument(
        '--valid-for',
        type=_validity,
        default=DEFAULT_VALIDITY,
        metavar='S',
        help=f'time in seconds within which a shot must be fired ({DEFAULT_VALIDITY:g})',
    )
    parser.add_argument(
        '--simulate-safety-inputs',
        action='store_true',
        help='publish that the emergency stop is released and the interlock closed; only for '
        'simulations; refused if another node publishes one of them',
    )


def _validity(text: str) -> float:
    seconds = float(text)
    if not 0.0 < seconds <= MAX_VALIDITY:
        raise argparse.ArgumentTypeError(
            f'{text} is not allowed; it must be above 0 and at most {MAX_VALIDITY:g} (s)'
        )
    return seconds


def parser_of(name: str, docstring: str | None) -> argparse.ArgumentParser:
    """Make the argument parser of a program that `ros2 run` starts."""
    return argparse.ArgumentParser(
        prog=f'ros2 run billiard_shot {name}',
        description=(docstring or '').strip().partition('\n')[0],
        epilog=EXIT_CODES + '\nROS arguments follow --ros-args, such as -r __ns:=/left_robot',
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def own_arguments(args: Sequence[str] | None) -> list[str]:
    """Return the arguments that are not ROS arguments."""
    return list(remove_ros_args(sys.argv if args is None else ['', *args])[1:])


def run_player(
    make: Callable[[], P],
    play_round: Callable[[P, R], bool],
    rounds: Iterable[R],
    name: str,
    args: Sequence[str] | None,
) -> None:
    """Make a player, play the rounds until one fails, and exit with one of `EXIT_CODES`."""
    caught: list[int] = []
    # The handlers of rclpy would shut down its context, and then no goal could be cancelled.
    with initialized(args, signal_handler_options=SignalHandlerOptions.NO):
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda number, _: caught.append(number))
        try:
            player = make()
            player.exit_on(caught)
            gc.freeze()  # a long garbage collection would silence the safety inputs
            player.wait_for_all()
            code = PLAYED if all(play_round(player, each) for each in rounds) else FAILED
        except (NotReadyError, TimeoutError) as error:
            print(f'{name}: {error}', file=sys.stderr)
            code = NOT_READY
    sys.exit(code)


def main(args: Sequence[str] | None = None) -> None:
    """Play strokes."""
    parser = parser_of('player', __doc__)
    add_stroke_arguments(parser)
    add_player_arguments(parser, scene=True)
    options = parser.parse_args(own_arguments(args))
    try:
        scene = Scene.load(options.scene)
        strokes = strokes_of(options, scene)
    except (ValueError, OSError) as error:
        parser.error(str(error))

    def play_stroke(player: Player, item: tuple[str, Stroke]) -> bool:
        name, stroke = item
        try:
            goal = player.goal(stroke, scene, f'{name} {short_id()}', options.valid_for)
        except RefusedError as error:
            print(f'{name}: {error}', flush=True)
            return False
        return play_shot(player, name, goal, options.arm)

    run_player(
        lambda: Player(
            simulate_safety_inputs=options.simulate_safety_inputs, timeout=options.wait
        ),
        play_stroke,
        strokes.items(),
        'player',
        args,
    )


if __name__ == '__main__':
    main()
