"""The node `cue_driver`: plays shots with the mechanical cue, and stops it when necessary."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
import traceback
from typing import Any, ClassVar

from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import CueState, Plan, Strike, TableState
from billiard_shot_msgs.srv import Arm
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action import ActionServer, CancelResponse
from rclpy.exceptions import InvalidParameterValueException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64, Header
from std_srvs.srv import Trigger

from billiard_shot.cue.controller import Command, Controller, MeasuredStrike, Result, Settings
from billiard_shot.cue.inputs import JointFeedback, read_latched, steady_time, write_latched
from billiard_shot.cue.mechanism import INCLINE, Mechanism
from billiard_shot.cue.model import elevation_joint
from billiard_shot.cue.plan import GoalOutcome, RefusedError
from billiard_shot.cue.safety import BEFORE_STROKE, LATCHED_STATES, MOVING, SafetyDecision
from billiard_shot.ros import conversions, node_runner, parameters
from billiard_shot.ros.commands import CommandTopic, ControllerClient
from billiard_shot.scene import Scene
from billiard_shot.scene.fields import choice, number

SUCCESS = TransitionCallbackReturn.SUCCESS

UNCONFIGURED = (
    'the node is not active: configure it, then activate it, or start it with autostart:=true'
)
NOT_ACTIVE = 'the node is not active: activate it'
ENDED = 'the node has been shut down'

DRIVER_REST_PERIOD = 0.1
"""Time between two ticks while nothing moves [s]."""

REMINDER_PERIOD = 8.0
"""Time after which the node logs again why it is not ready [s]."""

DEAF_TIME = 2.0
"""Time after a pause of this process within which the node must hear something [s]."""


@dataclass(frozen=True)
class CueDriverParameters(
    parameters.OfTable, parameters.OfGuidedScene, parameters.OfMechanism, parameters.OfUrgent
):
    """
    Parameters of the node.

    Parameters
    ----------
    autostart : bool
        Configure and activate the node at start-up.
    interface : str
        How the mechanism is commanded: `topic`, a trajectory on `~/actuation`, or
        `follow_joint_trajectory`, goals to the `controller`.
    controller : str
        Action of the controller, if `interface` is `follow_joint_trajectory`.
    period : float
        Time between two commands [s].
    alignment_limit : float
        Largest alignment of the mechanism, relative to 5 cm, 3 degrees, 10 % and 0.1 m/s.
    state_file : str
        Path of the file that keeps ESTOP and FAULT until they are cleared, also if the driver
        starts again. If it is empty, they are forgotten at the end of the driver.

    """

    READ_ONLY: ClassVar = ('autostart', 'interface', 'controller', 'niceness', 'period')
    autostart: bool = False
    interface: str = choice('topic', 'follow_joint_trajectory', default='topic')
    controller: str = parameters.checked(
        'joint_trajectory_controller/follow_joint_trajectory', parameters.check_topic
    )
    period: float = number('s', minimum=0.001, maximum=0.1, default=0.02)
    alignment_limit: float = number('', minimum=0.0, maximum=10.0, default=1.0)
    state_file: str = ''


class CueDriver(LifecycleNode):
    """
    Lifecycle node with the action `execute_shot` (billiard_shot_msgs/action/ExecuteShot).

    Publishes:

    - `~/incline_angle` (std_msgs/msg/Float64), the commanded elevation in radians;
    - if its parameter `interface` is `topic`, `~/actuation` (trajectory_msgs/msg/JointTrajectory),
      the current command. It is repeated, because the mechanism stops when commands cease;
    - `~/state` (billiard_shot_msgs/msg/CueState), latched;
    - `~/plan` (billiard_shot_msgs/msg/Plan), latched: the last plan that it began to carry out;
    - `~/strike` (billiard_shot_msgs/msg/Strike), the measured strike;
    - the elevation of the cue as a joint in `joint_states`, and `/diagnostics`.

    If `interface` is `follow_joint_trajectory`, it sends its commands as goals of that action to
    the controller of its parameter `controller` (`ControllerClient`).

    Services: `~/arm` (billiard_shot_msgs/srv/Arm), which names the shot, `~/disarm` and
    `~/clear_fault` (std_srvs/srv/Trigger). Subscribes to `joint_states`, `table_state`, and to
    `estop` (true means stop) and `interlock` (true means safe), std_msgs/msg/Bool. These two must
    be repeated by every publisher: silence stops the cue, and so do messages that were written too
    long ago. Another node that publishes commands is a fault.

    All of them exist while the node is configured, `/diagnostics` and the action always. Goals
    and requests are refused while the node is not active. It does not become active while another
    node has its name. Its parameters are `CueDriverParameters` and `Settings`. They can be set
    while the node is unconfigured.
    """

    def __init__(self) -> None:
        super().__init__('cue_driver')
        self._commands: CommandTopic | ControllerClient | None = None  # None: unconfigured
        parameters.declare(
            self,
            CueDriverParameters,
            Settings,
            fixed=lambda: (
                ''
                if self._commands is None
                else 'can be set only while the node is unconfigured; deactivate it and clean it '
                'up first'
            ),
        )
        self._own = parameters.values_of(CueDriverParameters, self)
        node_runner.set_niceness(self, self._own.niceness)
        self._decided = 0  # ROS time of the last decision [ns]
        self._goal: node_runner.GoalHandle | None = None  # that is being executed
        self._ended: dict[bytes, Future[Result]] = {}  # by ids of goals without an answer
        self._last_strike = Strike()
        self._rivals = ''  # why no motion can be commanded: another node has this name
        self._starts = False  # whether the node still has to activate itself
        self._has_looked = False  # whether other nodes have had a second to become known
        self._destroy: list[Callable[[], object]] = []  # what cleanup undoes
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        ActionServer(  # it still has to answer if the node is cleaned up just after a goal
            self,
            ExecuteShot,
            'execute_shot',
            self._end,
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
        )
        try:
            loaded = self._load()
        except (ValueError, OSError) as error:
            raise InvalidParameterValueException('scene or time-outs', '', str(error)) from None
        self._controller = Controller(
            *loaded,
            on_state=self._tell_state,
            on_command=self._send_command,
            on_strike=self._tell_strike,
            on_result=self._finish,
        )
        self._controller.deactivate(steady_time(), UNCONFIGURED, 'started')
        started = self.get_clock().now().nanoseconds
        self._controller.receive_clock(1e-9 * started, steady_time())
        node_runner.steady_timer(self, 1.0, self._look_after)
        self._starts = self._own.autostart and self.trigger_configure() is SUCCESS
        self._start()

    # --- lifecycle ------------------------------------------------------------------------------

    def _load(self) -> tuple[Mechanism, Scene, Settings]:
        """Load what the parameters say; raise ValueError or OSError if they cannot be used."""
        self._own = parameters.values_of(CueDriverParameters, self)
        settings = parameters.values_of(Settings, self)
        if settings.max_pause < 2.0 * self._own.period:
            raise ValueError(
                'estop_timeout, interlock_timeout, joint_states_timeout must be at least four '
                f'times the period, {self._own.period:g}, got {2 * settings.max_pause:g} (s)'
            )
        if settings.settle_time >= settings.arm_timeout:
            raise ValueError(
                f'settle_time must be below arm_timeout, {settings.arm_timeout:g}, or the cue '
                f'would disarm before it fires, got {settings.settle_time:g} (s)'
            )
        mechanism = Mechanism.load(self._own.mechanism)
        mechanism.alignment.check_plausible(self._own.alignment_limit)
        return mechanism, parameters.guided_scene(self._own.scene), settings

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start over with the current parameters; a latched state stays."""
        try:
            mechanism, scene, settings = self._load()
            latched = read_latched(Path(self._own.state_file)) if self._own.state_file else None
            self._make_interfaces(mechanism)
        except (ValueError, OSError) as error:
            self.get_logger().error(f'configure failed: {error}')
            return TransitionCallbackReturn.FAILURE
        if latched and self._controller.state not in LATCHED_STATES:
            self._controller.restore(*latched)
        self._controller.configure(mechanism, scene, settings)
        self._controller.deactivate(steady_time(), NOT_ACTIVE, 'configured')
        self.get_logger().info(f'alignment: {mechanism.alignment}')
        self._tell_state()
        return super().on_configure(state)

    def _make_interfaces(self, mechanism: Mechanism) -> None:
        """Make what others see; raise ValueError if the controller's action is not installed."""
        own, names = self._own, self._own.joint_names
        commands: CommandTopic | ControllerClient
        if own.interface == 'topic':
            commands = CommandTopic(self, '~/actuation', names, own.frame)
        else:
            commands = ControllerClient(self, own.controller, names, mechanism.accelerations)
        self._commands = commands
        self._feedback = JointFeedback(names)
        self._last_seen = 0  # stamp of the last table_state [ns]
        publishers = [
            self.create_publisher(Float64, '~/incline_angle', 10),
            self.create_publisher(CueState, '~/state', node_runner.EVERY_STATE),
            self.create_publisher(Plan, '~/plan', node_runner.LATCHED),
            self.create_publisher(Strike, '~/strike', 10),
            self.create_publisher(JointState, 'joint_states', 10),
        ]
        self._incline, self._state, self._plan, self._strike, self._joints = publishers
        subscriptions = [
            self.create_subscription(Bool, 'estop', self._on_estop, node_runner.SAFETY_INPUT),
            self.create_subscription(
                Bool, 'interlock', self._on_interlock, node_runner.SAFETY_INPUT
            ),
            self.create_subscription(
                JointState, 'joint_states', self._on_joints, node_runner.JOINT_STATES
            ),
            self.create_subscription(
                TableState, 'table_state', self._on_table, node_runner.LATCHED
            ),
        ]
        services = [
            self.create_service(Arm, '~/arm', _answering(self._arm)),
            self.create_service(Trigger, '~/disarm', _answering(self._disarm)),
            self.create_service(Trigger, '~/clear_fault', _answering(self._clear)),
        ]
        self._timer = node_runner.steady_timer(self, self._period, self._tick)
        self._destroy = [
            lambda: self.destroy_timer(self._timer),
            *(lambda each=each: self.destroy_service(each) for each in services),
            *(lambda each=each: self.destroy_subscription(each) for each in subscriptions),
            *(lambda each=each: self.destroy_publisher(each) for each in publishers),
            commands.close,
        ]

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Withdraw all interfaces, and allow parameters to be set."""
        self._controller.deactivate(steady_time(), UNCONFIGURED, 'cleaned up')
        self._commands, self._starts = None, False
        for destroy in self._destroy:
            destroy()
        return super().on_cleanup(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Accept goals from now on, unless another node has the name of this one."""
        if rival := self._rival():
            words = f'activate failed: {rival}'
            self.get_logger().error(words, throttle_duration_sec=REMINDER_PERIOD)
            return TransitionCallbackReturn.FAILURE
        result = super().on_activate(state)
        if result is SUCCESS:
            self._controller.activate()
            self._starts = False
            self.get_logger().info(f'ready: action {self.resolve_topic_name("execute_shot")}')
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Disarm, which stops the mechanism, and accept no more goals."""
        self._controller.deactivate(steady_time(), NOT_ACTIVE, 'deactivated')
        return super().on_deactivate(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Disarm first, in every state."""
        self._controller.deactivate(steady_time(), ENDED, 'shut down')
        self._starts = False
        return super().on_shutdown(state)

    def survive(self, error: Exception) -> None:
        """Latch a fault after an error of this program, and go on, to repeat the stop."""
        lines = ''.join(traceback.format_exception(error))
        self.get_logger().error(f'error of this program: {lines}')
        self._controller.fail(steady_time(), f'error of this program: {error!r}')

    def leave(self) -> None:
        """
        Stop the mechanism, and withdraw the publisher of commands.

        No other publisher is withdrawn, because in another process the end of a publisher can
        deadlock with an announcement (Fast DDS 3.2).
        """
        if self._commands:
            self._controller.deactivate(steady_time(), ENDED, 'the driver ends')
            self._commands.flush()
            self._commands.close()

    # --- inputs ---------------------------------------------------------------------------------

    def _on_estop(self, message: Bool, info: Mapping[str, Any]) -> None:
        now = steady_time()
        self._controller.receive_estop(
            message.data, node_runner.written(info, now), now, node_runner.publisher_of(info)
        )

    def _on_interlock(self, message: Bool, info: Mapping[str, Any]) -> None:
        now = steady_time()
        who = node_runner.publisher_of(info)
        self._controller.receive_interlock(message.data, node_runner.written(info, now), now, who)

    def _on_joints(self, message: JointState, info: Mapping[str, Any]) -> None:
        now = steady_time()
        time = min(
            node_runner.written(info, now),
            node_runner.stamped(message.header.stamp, self.get_clock(), now),
        )
        joints = self._feedback.update(message.name, message.position, message.velocity)
        self._controller.missing_joints = self._feedback.missing
        if joints:
            self._controller.receive_joints(*joints, time, now)

    def _on_table(self, message: TableState, info: Mapping[str, Any]) -> None:
        seen, clock = (
            node_runner.nanoseconds(message.header.stamp),
            self.get_clock().now().nanoseconds,
        )
        if 0 < seen < self._last_seen <= clock:  # else the clock was set
            older = 1e-9 * (self._last_seen - seen)
            self.get_logger().warning(f'ignored a table_state {older:.3g} s older than the last')
            return
        self._last_seen = seen
        now = steady_time()
        try:
            conversions.check_frame('header.frame_id', message.header, self._own.frame)
            balls = conversions.sightings_of(message.balls, message.header.stamp)
        except ValueError as error:
            self.get_logger().error(f'table_state: {error}; the table is not known any more')
            self._controller.reject_table(f'table_state: {error}', now)
        else:
            heard = node_runner.written(info, now)
            self._controller.receive_table(balls, 1e-9 * seen, heard, 1e-9 * clock, now)

    # --- requests -------------------------------------------------------------------------------

    def _arm(self, request: Arm.Request) -> SafetyDecision:
        return self._controller.arm(request.shot_id, steady_time())

    def _disarm(self, _: Trigger.Request) -> SafetyDecision:
        return self._controller.disarm(steady_time(), 'disarmed by service')

    def _clear(self, _: Trigger.Request) -> SafetyDecision:
        self._count_publishers()
        return self._controller.clear(steady_time())

    def _begin(self, goal: node_runner.GoalHandle) -> None:
        """Begin an accepted goal, before anything else happens; a task that waits ends it."""
        now = self.get_clock().now()
        self._decided = now.nanoseconds
        ended = self._ended[_id_of(goal)] = Future(executor=self.executor)
        # The last tick may be so long ago that a new plan would seem to be ahead of the clock.
        self._controller.receive_clock(1e-9 * self._decided, steady_time())
        try:
            remaining = conversions.seconds(goal.request.expiry) - conversions.seconds(
                now.to_msg()
            )
            plan = conversions.shot_plan_of(goal.request.plan, self._own.frame)
            self._controller.execute(
                plan, remaining, steady_time, allow_miscue=goal.request.allow_miscue
            )
        except RefusedError as error:
            self.get_logger().warning(f'refused: {error.outcome.name}: {error}')
            ended.set_result(Result(error.outcome, str(error)))
        except Exception as error:  # rclpy would end the goal with the outcome of success
            self.survive(error)
            ended.set_result(Result(GoalOutcome.FAULT, self._controller.reason))
        else:
            self._goal = goal
            self._plan.publish(goal.request.plan)
            goal.publish_feedback(ExecuteShot.Feedback(state=self._state_message()))
        goal.execute()

    async def _end(self, goal: node_runner.GoalHandle) -> ExecuteShot.Result:
        """Wait until a goal has ended, and answer it."""
        result = await self._ended[_id_of(goal)]
        del self._ended[_id_of(goal)]
        assert result is not None
        if result.outcome is GoalOutcome.OK:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return conversions.execution_result(result, self._last_strike)

    def _cancel(self, goal: node_runner.GoalHandle) -> CancelResponse:
        if goal is not self._goal or self._controller.state not in BEFORE_STROKE:
            return CancelResponse.REJECT
        self._controller.disarm(steady_time(), 'canceled', GoalOutcome.CANCELED)
        return CancelResponse.ACCEPT

    # --- periodic work --------------------------------------------------------------------------

    @property
    def _period(self) -> float:
        """Time between two ticks in the current state [s]."""
        rest = min(DRIVER_REST_PERIOD, 0.4 * self._controller.settings.max_pause)
        moves = self._controller.state in MOVING
        return self._own.period if moves else max(self._own.period, rest)

    def _tick(self) -> None:
        assert self._commands
        now = steady_time()
        self._decided = self.get_clock().now().nanoseconds
        controller, commands = self._controller, self._commands
        controller.receive_clock(1e-9 * self._decided, now)
        controller.receive_commands(
            commands.problem or self._rivals, commands.failure, commands.awaits_answer, now
        )
        controller.tick(now)
        if controller.command:
            commands.repeat(self._decided, controller.position, controller.velocity)
            if trajectory := controller.command.trajectory:
                length = float(trajectory.positions[-1, INCLINE])
                self._incline.publish(Float64(data=controller.mechanism.elevation(length)))
        if elevation := controller.measured_elevation(now):
            joint = JointState(name=[elevation_joint(self._own.joint_names)])
            joint.header.stamp = self.get_clock().now().to_msg()
            joint.position, joint.velocity = ([each] for each in elevation)
            self._joints.publish(joint)
        if now - controller.deaf_since > DEAF_TIME and any(
            self.count_publishers(name) for name in ('estop', 'interlock', 'table_state')
        ):
            raise node_runner.EndError(
                f'nothing has been received for {DEAF_TIME:g} s since this process paused'
            )

    def _look_after(self) -> None:
        """Do the work of every second."""
        self._start()
        if self._commands:
            self._count_publishers()
        self._publish_diagnostics()

    def _start(self) -> None:
        """Activate the node if it is to start by itself, and did not yet because of a rival."""
        if self._starts and self._has_looked:
            self.trigger_activate()
        self._has_looked = True  # a rival may not be known in the first second

    def _count_publishers(self) -> None:
        for each in (self._controller.estop, self._controller.interlock):
            each.keep(
                node_runner.publishers_of(self, self.resolve_topic_name(each.name)), steady_time()
            )
        self._rivals = self._rival()

    def _rival(self) -> str:
        """Return which other node has the name of this one; '' if none has."""
        own = self.get_name(), self.get_namespace()
        others = self.get_node_names_and_namespaces().count(own) - 1
        return f'another node is named {self.get_fully_qualified_name()}' if others > 0 else ''

    # --- outputs --------------------------------------------------------------------------------

    def _send_command(self, command: Command) -> None:
        if self._commands:
            self._commands.send(
                command, self._decided, self._controller.position, self._controller.velocity
            )

    def _tell_state(self) -> None:
        try:
            if self._own.state_file:  # the stop has been commanded
                path, controller = Path(self._own.state_file), self._controller
                write_latched(path, controller.state, controller.reason)
        except OSError as error:
            self.get_logger().error(f'state_file: the next start will not know the state: {error}')
        if not self._commands:
            return
        self._timer.timer_period_ns = round(1e9 * self._period)
        self._timer.reset()
        message = self._state_message()
        self._state.publish(message)
        self.get_logger().info(f'{self._controller.state.name}: {message.reason}')
        if self._goal:
            self._goal.publish_feedback(ExecuteShot.Feedback(state=message))

    def _tell_strike(self, strike: MeasuredStrike | None) -> None:
        self._last_strike = conversions.strike_message(
            self._controller.shot_id, strike, parameters.table_header(self)
        )
        if strike:
            self._strike.publish(self._last_strike)

    def _finish(self, result: Result) -> None:
        if self._goal:
            self._ended[_id_of(self._goal)].set_result(result)
        self._goal = None

    def _state_message(self) -> CueState:
        return CueState(
            header=Header(stamp=self.get_clock().now().to_msg()),
            state=int(self._controller.state),
            reason=self._controller.reason,
            shot_id=self._controller.shot_id,
        )

    def _publish_diagnostics(self) -> None:
        now, stamp = steady_time(), self.get_clock().now().to_msg()
        problems = self._controller.problems(now)
        name = self.get_fully_qualified_name()
        self._diagnostics.publish(
            conversions.diagnostics_message(name, self._controller, problems, stamp)
        )
        if wrong := '; '.join(filter(None, problems.values())):
            self.get_logger().warning(f'not ready: {wrong}', throttle_duration_sec=REMINDER_PERIOD)


def _id_of(goal: node_runner.GoalHandle) -> bytes:
    return bytes(goal.goal_id.uuid)


def _answering(act: Callable[[Any], SafetyDecision]) -> Callable[[Any, Any], Any]:
    """Make the callback of a service that acts on the controller and answers with its decision."""

    def answer(request: Any, response: Any) -> Any:
        decision = act(request)
        response.success = decision.accepted
        response.message = decision.reason or decision.state.name
        return response

    return answer


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    node_runner.spin_node(CueDriver, 'cue_driver', args, CueDriver.leave, CueDriver.survive)
