"""
Plays a shot through the whole loop: predict, execute, and compare what came of it.

    python -m billiard_shot.ros.player

Needs a predictor, a cue_driver that is active, a mechanism, and somebody who watches the table
(`make demo` has them simulated). Until there is a planner the strokes are those in `SHOTS`. The
emergency stop and the interlock are said by this program to be in order: only for a simulation.
"""
from collections.abc import Callable, Iterable, Sequence
import gc
import sys
from time import monotonic
from typing import Any, TypeVar
import uuid

from action_msgs.msg import GoalStatus
from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import CueState, TableState
from billiard_shot_msgs.srv import PredictShot
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
import rclpy
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.node import Node
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from billiard_shot import Scene, Status, Stroke
from billiard_shot.cue.outcome import Outcome
from billiard_shot.cue.safety import State
from billiard_shot.ros import conversions, cue_conversions
from billiard_shot.ros.client import call, START_UP
from billiard_shot.ros.running import EVERY_STATE, LATCHED

SHOTS = {
    'follow': Stroke.from_offsets(a=0.0, b=0.3, elevation=0.05, azimuth=0.0, speed=0.5),
    'side': Stroke.from_offsets(a=0.3, b=0.0, elevation=0.1, azimuth=2.8, speed=0.6),
    'massé': Stroke.from_offsets(a=0.3, b=0.3, elevation=0.9, azimuth=1.6, speed=1.5),
}
"""Strokes that are played one after the other, each from where the ball has come to rest."""

VALID = 60.0
"""Seconds for which a goal is valid."""

ALIVE = 0.05
"""Seconds between two messages that all is well."""

P = TypeVar('P', bound='Player')
R = TypeVar('R')


class Player(Node):
    """Node that plays shots and looks on."""

    def __init__(self, namespace: str = '') -> None:
        super().__init__('player', namespace=namespace)
        self.states: list[CueState] = []
        self.table: TableState | None = None
        self.all_is_well = True
        self.troubles: list[str] = []
        self._predict = self.create_client(PredictShot, 'predict_shot')
        self._arm = self.create_client(Trigger, 'cue_driver/arm')
        self._execute = ActionClient(self, ExecuteShot, 'execute_shot')
        self._estop = self.create_publisher(Bool, 'estop', 10)
        self._interlock = self.create_publisher(Bool, 'interlock', 10)
        self.create_timer(ALIVE, self._say)
        self.create_subscription(TableState, 'table_state', self._see, LATCHED)
        self.create_subscription(DiagnosticArray, '/diagnostics', self._diagnose, 10)
        self.create_subscription(CueState, 'cue_driver/state', self.states.append,
                                 EVERY_STATE)

    def _say(self) -> None:
        if self.all_is_well:
            self._estop.publish(Bool(data=False))
            self._interlock.publish(Bool(data=True))

    def _see(self, message: TableState) -> None:
        self.table = message

    def _diagnose(self, message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == self.resolve_topic_name('cue_driver'):
                self.troubles = [f'{each.key}: {each.value}' for each in status.values
                                 if each.key != 'shot_id' and each.value != 'ok']

    def until(self, condition: Callable[[], object], seconds: float) -> bool:
        """Spin until something is true; False if it is not in time."""
        deadline = monotonic() + seconds
        while not condition():
            if monotonic() > deadline:
                return False
            rclpy.spin_once(self, timeout_sec=0.05)
        return True

    def wait_for_all(self) -> None:
        """Wait for everybody that a shot needs; TimeoutError names who is missing."""
        for name, found in (
                ('service predict_shot', self._predict.service_is_ready),
                ('service cue_driver/arm', self._arm.service_is_ready),
                ('action execute_shot', self._execute.server_is_ready),
                ('topic table_state', lambda: self.table),
                ('topic cue_driver/state', lambda: self.states)):
            if not self.until(found, START_UP):
                raise TimeoutError(f'no {name} within {START_UP:g} s')
        self.troubles = ['no diagnostics']
        if not self.until(lambda: not self.troubles, START_UP):
            raise TimeoutError(f'cue_driver is not ready: {"; ".join(self.troubles)}')

    def goal(self, stroke: Stroke, scene: Scene, shot_id: str) -> ExecuteShot.Goal:
        """Goal for a stroke at the cue ball, where it lies now."""
        now = self.get_clock().now()
        plan = cue_conversions.plan_of(
            stroke, cue_conversions.balls_of(self.table.balls), scene, shot_id)
        return cue_conversions.goal_of(
            plan, uuid.uuid4().hex, now.to_msg(), (now + Duration(seconds=VALID)).to_msg())

    def predict(self, goal: ExecuteShot.Goal) -> PredictShot.Response:
        """Ask the predictor about the planned stroke."""
        request = PredictShot.Request(
            cue_pose=goal.plan.cue_pose, speed=goal.plan.speed, use_table_state=True)
        return call(self, self._predict, request, repeatable=True)

    def execute(self, goal: ExecuteShot.Goal, arm: bool = True) -> Any:
        """Send a goal, arm it once it is aimed, and return status and result when it has ended."""
        state: list[int] = []
        sent = self._execute.send_goal_async(
            goal, lambda message: state.append(message.feedback.state.state))
        rclpy.spin_until_future_complete(self, sent, timeout_sec=10.0)
        ended = sent.result().get_result_async()
        if arm and self.until(lambda: ended.done() or State.AIMED in state, 60.0):
            self._arm.call_async(Trigger.Request())
        self.until(ended.done, VALID)
        return ended.result()

    def rest(self, seconds: float = 60.0) -> np.ndarray | None:
        """Wait until the cue ball rests, at (x, y) [m]; None if that takes too long."""
        last, since = None, monotonic()
        deadline = monotonic() + seconds
        while monotonic() < deadline:
            rclpy.spin_once(self, timeout_sec=0.05)
            place = cue_conversions.balls_of(self.table.balls)[conversions.CUE_BALL]
            if place != last:
                last, since = place, monotonic()
            elif monotonic() - since > 0.5:
                return np.array(place)
        return None


def play(player: Player, name: str, stroke: Stroke, scene: Scene) -> bool:
    """Play one shot and print what was predicted and what came of it; whether all went well."""
    goal = player.goal(stroke, scene, f'{name} {uuid.uuid4().hex[:8]}')
    answer = player.predict(goal)
    status = Status(answer.status)
    print(f'{name}: {goal.plan.speed:g} m/s, elevation {goal.plan.elevation:g} rad')
    if status.refused:
        print(f'  predicted   {status.name}: {answer.message}')
        return False
    expected = conversions.vectors(answer.trajectory.positions)[-1][:2]
    response = player.execute(goal)
    result = response.result
    print(f'  executed    {Outcome(result.outcome).name}: {result.message}')
    if response.status != GoalStatus.STATUS_SUCCEEDED:
        return False
    rest = player.rest()
    if rest is None:
        print('  the ball does not come to rest')
        return False
    speed = result.strike.speed
    print(f'  measured    {speed:.4f} m/s ({100 * (speed / goal.plan.speed - 1):+.3f} %), '
          f'elevation {result.elevation:.5f} rad\n'
          f'  predicted   rests at ({expected[0]:.4f}, {expected[1]:.4f}) m\n'
          f'  came of it  rests at ({rest[0]:.4f}, {rest[1]:.4f}) m, '
          f'{1e3 * np.hypot(*(rest - expected)):.2f} mm from there', flush=True)
    return True


def play_rounds(
    make: Callable[[], P], play_round: Callable[[P, R, Scene], bool], rounds: Iterable[R],
    name: str, args: Sequence[str] | None,
) -> None:
    """Make a player, and play rounds once all is there; exit code 1 where one fails."""
    scene = Scene.load('paper')
    with rclpy.init(args=args):
        player = make()
        gc.freeze()  # a long look for garbage would be a silence, and so a stop
        try:
            player.wait_for_all()
        except TimeoutError as error:
            sys.exit(f'{name}: {error}')
        went_well = [play_round(player, each, scene) for each in rounds]
    sys.exit(not all(went_well))


def main(args: Sequence[str] | None = None) -> None:
    """Play all shots."""
    play_rounds(Player, lambda player, shot, scene: play(player, *shot, scene), SHOTS.items(),
                'player', args)


if __name__ == '__main__':
    main()
