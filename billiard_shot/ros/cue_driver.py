"""The node `cue_driver`: plays shots with the mechanical cue, and stops it where it must."""

from collections.abc import Callable, Sequence
import math
from time import monotonic
import uuid

from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import CueState, Strike, TableState
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import InvalidParameterValueException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.task import Future
from rclpy.time import Time
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from billiard_shot.cue.controller import Controller
from billiard_shot.cue.job import Command, Result
from billiard_shot.cue.measurement import Strike as MeasuredStrike
from billiard_shot.cue.mechanism import INCLINE, Mechanism
from billiard_shot.cue.outcome import Outcome, RefusedError
from billiard_shot.cue.safety import Decision, State
from billiard_shot.ros import cue_conversions as conversions
from billiard_shot.ros import cue_parameters, parameters
from billiard_shot.ros.conversions import check_frame
from billiard_shot.ros.running import be_urgent, EVERY_STATE, LATCHED, run, warm_up
from billiard_shot.ros.writing_time import stamped, written

SUCCESS = TransitionCallbackReturn.SUCCESS

UNCONFIGURED = (
    'the node is not active: configure it, then activate it, or start it with autostart:=true'
)
INACTIVE = 'the node is not active: activate it'

REMIND = 8.0
"""Seconds after which the node logs again why it is not ready."""


class CueDriver(LifecycleNode):
    """
    Lifecycle node with the action `execute_shot` (billiard_shot_msgs/action/ExecuteShot).

    Publishes `~/incline_angle` (std_msgs/msg/Float64), the commanded elevation in radians;
    `~/actuation` (trajectory_msgs/msg/JointTrajectory), which is repeated as long as it holds,
    for the mechanism stops when commands cease, and whose `header.frame_id` names the driver and
    numbers the command; `~/state` (billiard_shot_msgs/msg/CueState),
    latched;
    `~/strike` (billiard_shot_msgs/msg/Strike), what was measured; the elevation of the cue as a
    joint in `joint_states`; and `/diagnostics`. Services `~/arm`, `~/disarm` and `~/clear_fault`
    (std_srvs/srv/Trigger). Subscribes to `joint_states`, `table_state`, and to `estop` (true:
    stop) and `interlock` (true: safe), std_msgs/msg/Bool, which have to be repeated: silence means
    stop, and so do messages that were written too long ago. Another publisher of its commands is a
    fault.
    Its parameters are `cue_parameters.CUE_DRIVER`. They can be set while the node is unconfigured.
    """

    def __init__(self) -> None:
        super().__init__('cue_driver')
        self._life = UNCONFIGURED
        parameters.declare(
            self,
            cue_parameters.CUE_DRIVER,
            lambda: (
                ''
                if self._life is UNCONFIGURED
                else 'can be set only while the node is unconfigured; deactivate it and clean it '
                'up first'
            ),
        )
        be_urgent(self, self.get_parameter('niceness').value)
        self._called = self.get_clock().now()
        self._table: TableState | None = None
        self._waiting = -math.inf  # when it last logged why it is not ready
        self._goal: ServerGoalHandle | None = None
        self._ended: Future | None = None
        self._command = JointTrajectory()
        self._angle = Float64()
        topic = {
            name: self.get_parameter(f'{name}_topic').value for name in ('incline', 'actuation')
        }
        self._incline = self.create_lifecycle_publisher(Float64, topic['incline'], 10)
        self._actuation = self.create_lifecycle_publisher(JointTrajectory, topic['actuation'], 1)
        self._state = self.create_publisher(CueState, '~/state', EVERY_STATE)
        self._strike = self.create_publisher(Strike, '~/strike', 10)
        self._joints = self.create_publisher(JointState, 'joint_states', 10)
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        try:
            self._configure()
        except (ValueError, OSError) as error:
            raise InvalidParameterValueException('scene or time-outs', '', str(error)) from None

        # Deep queues: the stop may be pressed in one message and released in the next, and a
        # strike is measured from a series of joint_states. Old messages are not fresh anyway.
        self.create_subscription(Bool, 'estop', self._hear_estop, 10)
        self.create_subscription(Bool, 'interlock', self._hear_interlock, 10)
        self.create_subscription(JointState, 'joint_states', self._hear_joints, 50)
        self.create_subscription(TableState, 'table_state', self._hear_table, LATCHED)
        self.create_service(Trigger, '~/arm', self._arm)
        self.create_service(
            Trigger,
            '~/disarm',
            _answering(lambda: self._controller.disarm(monotonic(), 'disarmed by service')),
        )
        self.create_service(
            Trigger, '~/clear_fault', _answering(lambda: self._controller.clear(monotonic()))
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(self.get_parameter('period').value, self._tick, clock=steady)
        self.create_timer(1.0, self._diagnose, clock=steady)
        self._server = ActionServer(
            self, ExecuteShot, 'execute_shot', self._execute, cancel_callback=self._cancel
        )
        if self.get_parameter('autostart').value and self.trigger_configure() is SUCCESS:
            self.trigger_activate()

    # --- life -----------------------------------------------------------------------------------

    def _configure(self) -> None:
        """
        Take over the parameters.

        Raises
        ------
        ValueError, OSError
            If they do not fit together, or a file that they name cannot be read any more.

        """

        def value(name: str) -> object:
            return self.get_parameter(name).value

        self._names, self._incline_joint = value('joint_names'), value('incline_joint')
        scene = cue_parameters.guided_scene(value('scene'))
        self._name = uuid.uuid4().hex[:8]  # a new one, because commands are numbered anew
        warm_up(self, scene, other_balls=True, compiles=False)
        self._controller = Controller(
            Mechanism.load(value('mechanism')),
            scene,
            cue_parameters.settings_of(self),
            on_state=self._tell_state,
            on_command=self._give,
            on_strike=self._tell_strike,
            on_result=self._end,
        )
        if self._table:  # it is latched, and does not come again
            self._hear_table(self._table)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start over with the parameters as they are now."""
        try:
            self._configure()
        except (ValueError, OSError) as error:
            self.get_logger().error(f'configure failed: {error}')
            return TransitionCallbackReturn.FAILURE
        self._life = INACTIVE
        self._tell_state()
        return super().on_configure(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Allow parameters to be set."""
        self._life = UNCONFIGURED
        return super().on_cleanup(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """From now on goals are executed."""
        result = super().on_activate(state)
        if result is SUCCESS:
            self._life = ''
            self.get_logger().info(f'ready: action {self.resolve_topic_name("execute_shot")}')
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Disarm, which stops the mechanism, and execute no more goals."""
        self._controller.disarm(monotonic(), 'deactivated')
        self._life = INACTIVE
        return super().on_deactivate(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Disarm first, whatever is going on."""
        if not self._life:
            self.on_deactivate(state)
        return super().on_shutdown(state)

    # --- what it hears and is asked for ---------------------------------------------------------

    def _hear_estop(self, message: Bool, info: dict[str, int]) -> None:
        now = monotonic()
        self._controller.hear_estop(message.data, written(info, now), now)

    def _hear_interlock(self, message: Bool, info: dict[str, int]) -> None:
        now = monotonic()
        self._controller.hear_interlock(message.data, written(info, now), now)

    def _hear_joints(self, message: JointState, info: dict[str, int]) -> None:
        joints = conversions.joints_of(message, self._names)
        if joints:
            now = monotonic()
            stamp = stamped(Time.from_msg(message.header.stamp), self.get_clock(), now)
            self._controller.hear_joints(*joints, min(written(info, now), stamp), now)

    def _hear_table(self, message: TableState) -> None:
        self._table = message
        try:
            check_frame('header.frame_id', message.header, self.get_parameter('frame').value)
            self._controller.hear_table(conversions.balls_of(message.balls))
        except ValueError as error:
            self.get_logger().error(f'ignored a table_state: {error}')

    def _arm(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        decision = (
            self._controller.arm(monotonic())
            if not self._life
            else Decision(False, self._controller.state, f'arm: {self._life}')
        )
        return _answer(response, decision)

    async def _execute(self, goal: ServerGoalHandle) -> ExecuteShot.Result:
        self._called = self.get_clock().now()
        now = self._called.to_msg()
        try:
            if self._life:
                raise RefusedError(Outcome.NOT_READY, self._life)
            self._controller.execute(
                conversions.order_of(goal.request, now, self.get_parameter('frame').value),
                monotonic(),
            )
        except RefusedError as error:
            self.get_logger().warning(f'refused: {error.outcome.name}: {error}')
            goal.abort()
            return conversions.result_of(
                Result(error.outcome, str(error), None), parameters.table_header(self)
            )
        self._goal, self._ended = goal, Future(executor=self.executor)
        goal.publish_feedback(ExecuteShot.Feedback(state=self._state_message()))
        result: Result = await self._ended
        if result.outcome is Outcome.OK:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return conversions.result_of(result, parameters.table_header(self))

    def _cancel(self, goal: ServerGoalHandle) -> CancelResponse:
        if goal is not self._goal or self._controller.state not in (
            State.AIMING,
            State.AIMED,
            State.ARMED,
        ):
            return CancelResponse.REJECT
        self._controller.disarm(monotonic(), 'canceled', Outcome.CANCELED)
        return CancelResponse.ACCEPT

    # --- what it says ---------------------------------------------------------------------------

    def _tick(self) -> None:
        now = monotonic()
        self._called = self.get_clock().now()
        self._controller.hear_clock(1e-9 * self._called.nanoseconds, now)
        self._controller.hear_rivals(self._other_drivers(), now)
        self._controller.tick(now)
        if self._controller.command:
            self._actuation.publish(self._command)
            self._incline.publish(self._angle)
        elevation = self._controller.measured_elevation(now)
        if elevation:
            self._joints.publish(
                conversions.joints_message(
                    [self._incline_joint],
                    *map(np.atleast_1d, elevation),
                    self.get_clock().now().to_msg(),
                )
            )

    def _give(self, command: Command) -> None:
        """
        Publish a new command, which `_tick` repeats.

        A path has the stamp of the decision. If this process is stopped between the decision and
        the publication, the mechanism sees that the command is old.
        """
        name = conversions.command_name(self._name, command.number)
        if command.path is None:
            self._command = conversions.stop_message(self._controller.position, self._names, name)
        else:
            self._command = conversions.trajectory_message(
                command.path, self._names, self._called.to_msg(), name
            )
            self._angle.data = self._controller.mechanism.triangle.elevation(
                float(command.path.positions[-1, INCLINE])
            )
        self._actuation.publish(self._command)

    def _other_drivers(self) -> list[str]:
        """Names of other nodes that publish commands; only an active driver cares."""
        topic = self._actuation.topic_name
        if self._life or self.count_publishers(topic) < 2:
            return []
        # A publisher is discovered a little earlier than the name of its node.
        nodes = [
            f'{each.node_namespace.rstrip("/")}/{each.node_name}'.replace(
                '_NODE_NAMESPACE_UNKNOWN_/_NODE_NAME_UNKNOWN_', 'its name is not known yet'
            )
            for each in self.get_publishers_info_by_topic(topic)
        ]
        own = self.get_fully_qualified_name()
        if own in nodes:
            nodes.remove(own)
        return nodes

    def _tell_state(self) -> None:
        message = self._state_message()
        self._state.publish(message)
        self.get_logger().info(f'{self._controller.state.name}: {message.reason}')
        if self._goal:
            self._goal.publish_feedback(ExecuteShot.Feedback(state=message))

    def _tell_strike(self, strike: MeasuredStrike) -> None:
        self._strike.publish(conversions.strike_message(strike, parameters.table_header(self)))

    def _end(self, result: Result) -> None:
        self._goal = None
        if self._ended:
            self._ended.set_result(result)

    def _state_message(self) -> CueState:
        return conversions.state_message(self._controller, self.get_clock().now().to_msg())

    def _diagnose(self) -> None:
        now = monotonic()
        health = conversions.health(self._controller, self._life, now)
        self._diagnostics.publish(
            conversions.diagnostics_message(
                self.get_fully_qualified_name(),
                self._controller,
                health,
                self.get_clock().now().to_msg(),
            )
        )
        wrong = [value for value in health.values() if value != 'ok']
        if not wrong:
            self._waiting = -math.inf
        elif now - self._waiting > REMIND:
            self._waiting = now
            self.get_logger().warning(f'not ready: {"; ".join(wrong)}')


def _answering(act: Callable[[], Decision]) -> Callable[..., Trigger.Response]:
    """Service that does something and says what came of it."""
    return lambda _, response: _answer(response, act())


def _answer(response: Trigger.Response, decision: Decision) -> Trigger.Response:
    response.success = decision.accepted
    response.message = decision.reason or decision.state.name
    return response


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    run(CueDriver, 'cue_driver', args)


if __name__ == '__main__':
    main()
