"""
Play strokes with the mechanical cue: predict, execute, and compare the cue ball's resting place.

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
from typing import Any, TypeVar

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import CueState, TableState
from billiard_shot_msgs.srv import PredictShot
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args
from std_msgs.msg import Bool, Header
from std_srvs.srv import Trigger

from billiard_shot import Scene, Status, Stroke
from billiard_shot.cue.outcome import Outcome
from billiard_shot.cue.safety import State
from billiard_shot.ros import conversions, cue_conversions
from billiard_shot.ros.client import call, START_UP
from billiard_shot.ros.running import EVERY_STATE, initialized, LATCHED
from billiard_shot.ros.sealing import LONGEST, sealed_goal, short_id, VALID_FOR
from billiard_shot.shot.stroke_options import add_stroke_arguments, strokes_of

ALIVE = 0.05
"""Seconds between two messages of the simulated safety inputs."""

DISCOVERY = 1.0
"""Seconds in which other publishers are discovered, before anything is simulated."""

SAFETY_INPUTS = {'estop': False, 'interlock': True}
"""Topics of the safety inputs, and the values with which the cue may move."""

SOON = 2.0
"""Seconds of waiting about which nothing is said."""

STILL = 1e-3
"""Metres: a ball that moves less within `AT_REST` seconds rests."""

AT_REST = 0.5

PLAYED, FAILED, NOT_READY = 0, 1, 3
"""Exit codes; argparse ends with 2."""

EXIT_CODES = """\
exit codes:
  0  every shot was played, and reached its target if it has one
  1  a shot was refused, ended early, or missed its target; the output says why, and the
     shots after it are not played
  2  the arguments are wrong
  3  a node is missing or not ready; the message names it
  130, 143  ended by Ctrl+C or SIGTERM; a shot that has not begun is cancelled
"""

P = TypeVar('P', bound='Player')
R = TypeVar('R')


class NotReadyError(RuntimeError):
    """Something that a shot needs is missing."""


class Player(Node):
    """
    Node that plays shots and watches the table.

    Parameters
    ----------
    namespace : str
        Of the node; '' for that of the command line.
    simulate_safety_inputs : bool
        Whether to publish that the emergency stop is released and the interlock closed. Only for
        simulations: on a robot these messages come from the safety equipment.
    patience : float
        Seconds to wait for each of the other nodes.

    """

    def __init__(
        self,
        namespace: str = '',
        simulate_safety_inputs: bool = False,
        patience: float = START_UP,
    ) -> None:
        super().__init__('player', namespace=namespace)
        self._patience = patience
        self.states: list[CueState] = []
        self.table: TableState | None = None
        self.all_is_well = True
        self.troubles: list[str] = []
        self._predict = self.create_client(PredictShot, 'predict_shot')
        self._arm = self.create_client(Trigger, 'cue_driver/arm')
        self._execute = ActionClient(self, ExecuteShot, 'execute_shot')
        self.create_subscription(TableState, 'table_state', self._see, LATCHED)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._diagnose, 10)
        self.create_subscription(CueState, 'cue_driver/state', self.states.append, EVERY_STATE)
        self._safety: dict[str, Any] = {}
        self._discovered = monotonic() + DISCOVERY
        if simulate_safety_inputs:
            self.get_logger().warning(
                'simulating the emergency stop and the interlock: never do this on a robot'
            )
            self._safety = {name: self.create_publisher(Bool, name, 10) for name in SAFETY_INPUTS}
            self.create_timer(ALIVE, self._say)

    def _say(self) -> None:
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
        if self.all_is_well and monotonic() > self._discovered:
            for name, value in SAFETY_INPUTS.items():
                self._safety[name].publish(Bool(data=value))

    def _see(self, message: TableState) -> None:
        self.table = message

    def _diagnose(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == self.resolve_topic_name('cue_driver'):
                self.troubles = [
                    f'{each.key}: {each.value}'
                    for each in status.values
                    if each.key != 'shot_id' and each.value != 'ok'
                ]

    def until(self, condition: Callable[[], object], seconds: float) -> bool:
        """Spin until something is true; False if it is not in time."""
        deadline = monotonic() + seconds
        while not condition():
            if monotonic() > deadline:
                return False
            rclpy.spin_once(self, timeout_sec=0.05)
        return True

    def wait_for_all(self) -> None:
        """Wait for everything that a shot needs; NotReadyError names what is missing."""
        for name, found in (
            ('service predict_shot', self._predict.service_is_ready),
            ('service cue_driver/arm', self._arm.service_is_ready),
            ('action execute_shot', self._execute.server_is_ready),
            ('topic table_state', lambda: self.table),
            ('topic cue_driver/state', lambda: self.states),
        ):
            self.wait_for(*name.split(), found)
        if self._safety:  # else a shot could end before safety equipment is discovered
            self.until(lambda: monotonic() > self._discovered, DISCOVERY)
        self.troubles = ['no diagnostics']
        if not self.until(lambda: not self.troubles, self._patience):
            raise NotReadyError(f'cue_driver is not ready: {"; ".join(self.troubles)}')

    def wait_for(self, kind: str, name: str, found: Callable[[], object]) -> None:
        """Wait for a service, action or topic, and say so if it takes a while."""
        name = f'{kind} {self.resolve_topic_name(name)}'
        if self.until(found, min(SOON, self._patience)):
            return
        self.get_logger().info(f'waiting for {name}')
        if not self.until(found, self._patience - SOON):
            raise NotReadyError(f'no {name} within {self._patience:g} s')

    def balls(self) -> dict[str, tuple[float, float]]:
        """Where the balls on the table lie now, (x, y) [m]."""
        return cue_conversions.balls_of(self.table.balls)

    def goal(
        self, stroke: Stroke, scene: Scene, shot_id: str, valid_for: float = VALID_FOR
    ) -> ExecuteShot.Goal:
        """Sealed goal for a stroke at the cue ball, where it lies now."""
        plan = cue_conversions.plan_of(stroke, self.balls(), scene, shot_id)
        header = Header(frame_id=self.table.header.frame_id, stamp=self.get_clock().now().to_msg())
        return sealed_goal(plan, header, valid_for)

    def predict(self, goal: ExecuteShot.Goal) -> PredictShot.Response:
        """Ask the predictor about the planned stroke."""
        request = PredictShot.Request(
            cue_pose=goal.plan.cue_pose, speed=goal.plan.speed, use_table_state=True
        )
        return call(self, self._predict, request, repeatable=True)

    def execute(
        self,
        goal: ExecuteShot.Goal,
        arm: bool = True,
        on_aimed: Callable[[], None] = lambda: None,
    ) -> Any:
        """
        Send a goal, and return status and result when it has ended.

        Parameters
        ----------
        goal
        arm : bool
            Whether to arm the cue as soon as it is aimed; otherwise somebody else has to.
        on_aimed : callable
            Called when the cue is aimed and waits to be armed.

        If this is interrupted, such as by Ctrl+C, the goal is cancelled.

        """
        sent = self._execute.send_goal_async(goal)
        if not self.until(sent.done, 10.0):
            raise NotReadyError('no answer from action execute_shot within 10 s')
        ended = sent.result().get_result_async()
        try:
            self._wait_for_end(goal, ended, arm, on_aimed)
        finally:
            if not ended.done():
                sent.result().cancel_goal_async()
                self.until(ended.done, 2.0)
        if not ended.done():
            raise NotReadyError('action execute_shot does not end')
        return ended.result()

    def _wait_for_end(
        self, goal: ExecuteShot.Goal, ended: Any, arm: bool, on_aimed: Callable[[], None]
    ) -> None:
        now = self.get_clock().now().nanoseconds
        left = goal.expiry.sec + 1e-9 * (goal.expiry.nanosec - now) + 60.0
        if self.until(lambda: ended.done() or self._is_aimed(goal), left) and not ended.done():
            on_aimed()
            if arm:
                answer = self._arm.call_async(Trigger.Request())
                self.until(lambda: answer.done() or ended.done(), 10.0)
                if answer.done() and not answer.result().success:
                    self.get_logger().error(f'not armed: {answer.result().message}')
                    return
        self.until(ended.done, left)

    def _is_aimed(self, goal: ExecuteShot.Goal) -> bool:
        last = self.states[-1]
        return last.state == State.AIMED and last.shot_id == goal.plan.shot_id

    def rest(self, seconds: float = 60.0) -> np.ndarray | None:
        """Wait until the cue ball rests, at (x, y) [m]; None if it does not, or has fallen."""
        last, since = (math.inf, math.inf), monotonic()
        deadline = monotonic() + seconds
        while monotonic() < deadline:
            rclpy.spin_once(self, timeout_sec=0.05)
            place = self.balls().get(conversions.CUE_BALL)
            if place is None:
                return None
            if not math.dist(place, last) <= STILL:
                last, since = place, monotonic()
            elif monotonic() - since > AT_REST:
                return np.array(place)
        return None


def play(player: Player, name: str, goal: ExecuteShot.Goal, arm: bool) -> bool:
    """Play one shot and print the prediction and the outcome; whether it was played."""
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
                f'  aimed       to fire: ros2 service call {service} std_srvs/srv/Trigger',
                flush=True,
            )

    response = player.execute(goal, arm, tell_how_to_arm)
    result = response.result
    print(f'  executed    {Outcome(result.outcome).name}: {result.message}')
    if response.status != GoalStatus.STATUS_SUCCEEDED:
        return False
    rest = player.rest()
    speed = result.strike.speed
    print(
        f'  measured    {speed:.4f} m/s ({100 * (speed / goal.plan.speed - 1):+.3f} %), '
        f'elevation {result.elevation:.5f} rad\n'
        f'  predicted   rests at ({expected[0]:.4f}, {expected[1]:.4f}) m'
    )
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
    """Options of both players; `scene`: whether one has to be known."""
    if scene:
        parser.add_argument(
            '--scene',
            default='paper',
            metavar='SCENE',
            help='bundled scene or YAML file, that of the cue_driver (paper)',
        )
    parser.add_argument(
        '--arm',
        action='store_true',
        help='arm each shot as soon as it is aimed; otherwise wait until somebody calls the '
        'service cue_driver/arm',
    )
    parser.add_argument(
        '--wait',
        type=float,
        default=START_UP,
        metavar='S',
        help=f'seconds to wait for each node ({START_UP:g})',
    )
    parser.add_argument(
        '--valid-for',
        type=_validity,
        default=VALID_FOR,
        metavar='S',
        help=f'seconds within which a shot has to be fired ({VALID_FOR:g})',
    )
    parser.add_argument(
        '--simulate-safety-inputs',
        action='store_true',
        help='publish that the emergency stop is released and the interlock closed; only for '
        'simulations; refused if another node publishes one of them',
    )


def _validity(text: str) -> float:
    seconds = float(text)
    if not 0.0 < seconds <= LONGEST:
        raise argparse.ArgumentTypeError(
            f'{text} is not allowed; it must be above 0 and at most {LONGEST:g} (s)'
        )
    return seconds


def parser_of(name: str, text: str) -> argparse.ArgumentParser:
    """Parser of a program that `ros2 run` starts."""
    return argparse.ArgumentParser(
        prog=f'ros2 run billiard_shot {name}',
        description=text,
        epilog=EXIT_CODES + '\nROS arguments follow --ros-args, such as -r __ns:=/left_robot',
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def own_arguments(args: Sequence[str] | None) -> list[str]:
    """Arguments that are not for ROS."""
    return remove_ros_args(sys.argv if args is None else ['', *args])[1:]


def run_player(
    make: Callable[[], P],
    play_round: Callable[[P, R], bool],
    rounds: Iterable[R],
    name: str,
    args: Sequence[str] | None,
) -> None:
    """Make a player, play the rounds until one fails, and end with one of `EXIT_CODES`."""

    def end(number: int, _: object) -> None:
        sys.exit(128 + number)

    # Not the handlers of rclpy: with its context shut down, no goal can be cancelled.
    with initialized(args, signal_handler_options=SignalHandlerOptions.NO):
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, end)
        try:
            player = make()
            gc.freeze()  # a long search for garbage would be a silence, and silence means stop
            player.wait_for_all()
            code = PLAYED if all(play_round(player, each) for each in rounds) else FAILED
        except (NotReadyError, TimeoutError) as error:
            print(f'{name}: {error}', file=sys.stderr)
            code = NOT_READY
    sys.exit(code)


def main(args: Sequence[str] | None = None) -> None:
    """Play strokes."""
    parser = parser_of('player', __doc__.strip().splitlines()[0])
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
        goal = player.goal(stroke, scene, f'{name} {short_id()}', options.valid_for)
        return play(player, name, goal, options.arm)

    run_player(
        lambda: Player(
            simulate_safety_inputs=options.simulate_safety_inputs, patience=options.wait
        ),
        play_stroke,
        strokes.items(),
        'player',
        args,
    )


if __name__ == '__main__':
    main()
