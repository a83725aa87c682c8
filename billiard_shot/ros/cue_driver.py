"""The node `cue_driver`: plays shots with the mechanical cue, and stops it when necessary."""

from collections.abc import Callable, Mapping, Sequence
import math
import traceback
from typing import Any, TypeAlias
import uuid

from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import CueState, Strike, TableState
from billiard_shot_msgs.srv import Arm
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.duration import Duration
from rclpy.exceptions import InvalidParameterValueException
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectory

from billiard_shot import machine_code
from billiard_shot.cue.clock import steady_time
from billiard_shot.cue.controller import Controller
from billiard_shot.cue.execution import Command, Result
from billiard_shot.cue.measurement import Strike as MeasuredStrike
from billiard_shot.cue.mechanism import INCLINE, Mechanism
from billiard_shot.cue.outcome import Outcome, RefusedError
from billiard_shot.cue.safety import Decision, State
from billiard_shot.ros import cue_conversions as conversions
from billiard_shot.ros import cue_parameters, parameters
from billiard_shot.ros.conversions import check_frame, sightings_of
from billiard_shot.ros.node_runner import (
    EVERY_STATE,
    JOINT_STATES,
    LATCHED,
    run,
    SAFETY_INPUT,
    set_niceness,
    steady_timer,
    warm_up,
)
from billiard_shot.ros.writing_time import nanoseconds, stamped, written

GoalHandle: TypeAlias = 'ServerGoalHandle[Any, Any, Any]'

SUCCESS = TransitionCallbackReturn.SUCCESS

UNCONFIGURED = (
    'the node is not active: configure it, then activate it, or start it with autostart:=true'
)
INACTIVE = 'the node is not active: activate it'

REMINDER_PERIOD = 8.0
"""Time after which the node logs again why it is not ready [s]."""


FAREWELL = 0.5
"""Longest time that an ending driver waits until the mechanism has received the stop [s]."""


class CueDriver(LifecycleNode):
    """
    Lifecycle node with the action `execute_shot` (billiard_shot_msgs/action/ExecuteShot).

    Publishes:

    - `~/incline_angle` (std_msgs/msg/Float64), the commanded elevation in radians;
    - `~/actuation` (trajectory_msgs/msg/JointTrajectory), the current command. It is repeated,
      because the mechanism stops when commands cease. `header.frame_id` contains the driver and
      the number of the command;
    - `~/state` (billiard_shot_msgs/msg/CueState), latched;
    - `~/strike` (billiard_shot_msgs/msg/Strike), the measured strike;
    - the elevation of the cue as a joint in `joint_states`, and `/diagnostics`.

    Services: `~/arm` (billiard_shot_msgs/srv/Arm), which names the shot, `~/disarm` and
    `~/clear_fault` (std_srvs/srv/Trigger). Subscribes to
    `joint_states`, `table_state`, and to `estop` (true means stop) and `interlock` (true means
    safe), std_msgs/msg/Bool. These two must be repeated: silence stops the cue, and so do messages
    that were written too long ago. Another node that publishes commands is a fault.
    Its parameters are `cue_parameters.CUE_DRIVER`. They can be set while the node is unconfigured.
    """

    def __init__(self) -> None:
        super().__init__('cue_driver')
        self._inactive = UNCONFIGURED
        parameters.declare(
            self,
            cue_parameters.CUE_DRIVER,
            lambda: (
                ''
                if self._inactive is UNCONFIGURED
                else 'can be set only while the node is unconfigured; deactivate it and clean it '
                'up first'
            ),
        )
        set_niceness(self, self.get_parameter('niceness').value)
        self._decision_time = self.get_clock().now()
        self._table: TableState | None = None
        self._reminded = -math.inf  # time of the last log that the node is not ready
        self._goal: GoalHandle | None = None
        self._ended: Future[Result] | None = None
        self._command = JointTrajectory()
        self._angle = Float64()
        topic = {
            name: self.get_parameter(f'{name}_topic').value for name in ('incline', 'actuation')
        }
        self._incline = self.create_lifecycle_publisher(Float64, topic['incline'], 10)
        self._actuation = self.create_lifecycle_publisher(JointTrajectory, topic['actuation'], 1)
        self._state = self.create_publisher(CueState, '~/state', EVERY_STATE)
        self._strike = self.create_publisher(Strike, '~/strike', 10)
        self._last_strike = Strike()
        self._joints = self.create_publisher(JointState, 'joint_states', 10)
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        try:
            self._controller = self._configure()
        except (ValueError, OSError) as error:
            raise InvalidParameterValueException('scene or time-outs', '', str(error)) from None

        # Deep queues: the stop may be pressed in one message and released in the next. Messages
        # that waited are not fresh.
        self.create_subscription(Bool, 'estop', self._on_estop, SAFETY_INPUT)
        self.create_subscription(Bool, 'interlock', self._on_interlock, SAFETY_INPUT)
        self.create_subscription(JointState, 'joint_states', self._on_joints, JOINT_STATES)
        self.create_subscription(TableState, 'table_state', self._on_table, LATCHED)
        self.create_service(
            Arm,
            '~/arm',
            _answering(
                lambda request: (
                    self._refused('arm') or self._controller.arm(request.shot_id, steady_time())
                )
            ),
        )
        self.create_service(
            Trigger,
            '~/disarm',
            _answering(lambda _: self._controller.disarm(steady_time(), 'disarmed by service')),
        )
        self.create_service(
            Trigger,
            '~/clear_fault',
            _answering(lambda _: self._refused('clear') or self._controller.clear(steady_time())),
        )
        steady_timer(self, self.get_parameter('period').value, self._tick)
        steady_timer(self, 1.0, self._publish_diagnostics)
        steady_timer(self, 1.0, self._load_machine_code)
        self._server = ActionServer(
            self, ExecuteShot, 'execute_shot', self._execute, cancel_callback=self._cancel
        )
        if self.get_parameter('autostart').value and self.trigger_configure() is SUCCESS:
            self.trigger_activate()

    # --- lifecycle ------------------------------------------------------------------------------

    def _configure(self) -> Controller:
        """
        Apply the parameters, and make a controller.

        Raises
        ------
        ValueError, OSError
            If parameters contradict each other, or if a file that they name can no longer be read.

        """

        def value(name: str) -> Any:
            return self.get_parameter(name).value

        self._names, self._incline_joint = value('joint_names'), value('incline_joint')
        scene = cue_parameters.guided_scene(value('scene'))
        self._name = uuid.uuid4().hex[:8]  # a new name, because the numbers of commands start over
        warm_up(self, scene, other_balls=True, compiles=False)
        return Controller(
            Mechanism.load(value('mechanism')),
            scene,
            cue_parameters.settings_of(self),
            on_state=self._tell_state,
            on_command=self._publish_command,
            on_strike=self._tell_strike,
            on_result=self._finish,
        )

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start over with the current parameters; a latched state stays."""
        before = self._controller
        try:
            self._controller = self._configure()
        except (ValueError, OSError) as error:
            self.get_logger().error(f'configure failed: {error}')
            return TransitionCallbackReturn.FAILURE
        self._controller.take_over(before)
        if self._table:  # it is latched, and is not sent again
            self._on_table(self._table)
        self._inactive = INACTIVE
        self._tell_state()
        return super().on_configure(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Allow parameters to be set."""
        self._inactive = UNCONFIGURED
        return super().on_cleanup(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Accept goals from now on."""
        result = super().on_activate(state)
        if result is SUCCESS:
            self._inactive = ''
            self.get_logger().info(f'ready: action {self.resolve_topic_name("execute_shot")}')
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Disarm, which stops the mechanism, and accept no more goals."""
        self._controller.disarm(steady_time(), 'deactivated')
        self._inactive = INACTIVE
        return super().on_deactivate(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Disarm first, in every state."""
        if not self._inactive:
            self.on_deactivate(state)
        return super().on_shutdown(state)

    def survive(self, error: Exception) -> None:
        """Latch a fault after an error of this program, and go on, to repeat the stop."""
        lines = ''.join(traceback.format_exception(error))
        self.get_logger().error(f'error of this program: {lines}')
        self._controller.fail(steady_time(), f'error of this program: {error!r}')

    def leave(self) -> None:
        """
        Stop the mechanism, and withdraw the publisher of commands.

        The end of a process does not withdraw it. A new driver would see this driver until its
        lease expires, 20 s later, and would report it as a second driver. No other publisher is
        withdrawn, because in another process the end of a publisher can deadlock with an
        announcement (Fast DDS 3.2).
        """
        self._controller.disarm(steady_time(), 'the driver ends')
        self._actuation.wait_for_all_acked(Duration(seconds=FAREWELL))
        self.destroy_publisher(self._actuation)

    # --- inputs and requests --------------------------------------------------------------------

    def _on_estop(self, message: Bool, info: Mapping[str, Any]) -> None:
        now = steady_time()
        self._controller.receive_estop(message.data, written(info, now), now)

    def _on_interlock(self, message: Bool, info: Mapping[str, Any]) -> None:
        now = steady_time()
        self._controller.receive_interlock(message.data, written(info, now), now)

    def _on_joints(self, message: JointState, info: Mapping[str, Any]) -> None:
        joints = conversions.joints_of(message, self._names)
        if joints:
            now = steady_time()
            stamp = stamped(message.header.stamp, self.get_clock(), now)
            self._controller.receive_joints(*joints, min(written(info, now), stamp), now)

    def _on_table(self, message: TableState) -> None:
        seen, now = nanoseconds(message.header.stamp), self.get_clock().now().nanoseconds
        last = nanoseconds(self._table.header.stamp) if self._table else seen
        if 0 < seen < last <= now:  # else the clock was set
            older = 1e-9 * (last - seen)
            self.get_logger().warning(f'ignored a table_state {older:.3g} s older than the last')
            return
        try:
            check_frame('header.frame_id', message.header, self.get_parameter('frame').value)
            self._controller.receive_table(sightings_of(message.balls, message.header.stamp))
            self._table = message
        except ValueError as error:
            self.get_logger().error(f'table_state: {error}; the table is not known any more')
            self._controller.receive_table(None)
            self._table = None

    def _refused(self, name: str) -> Decision | None:
        """Return the refusal of a request if the node is not active; None if it is active."""
        if not self._inactive:
            return None
        return Decision(False, self._controller.state, f'{name}: {self._inactive}')

    async def _execute(self, goal: GoalHandle) -> ExecuteShot.Result:
        self._decision_time = self.get_clock().now()
        now = self._decision_time.to_msg()
        try:
            if self._inactive:
                raise RefusedError(Outcome.NOT_READY, self._inactive)
            self._controller.execute(
                conversions.shot_goal_of(goal.request, now, self.get_parameter('frame').value),
                steady_time,
            )
        except RefusedError as error:
            self.get_logger().warning(f'refused: {error.outcome.name}: {error}')
            return _aborted(goal, error.outcome, str(error))
        except Exception as error:  # rclpy would end the goal with the outcome of success
            self.survive(error)
            return _aborted(goal, Outcome.FAULT, self._controller.reason)
        self._goal, self._ended = goal, Future(executor=self.executor)
        goal.publish_feedback(ExecuteShot.Feedback(state=self._state_message()))
        result = await self._ended
        assert result is not None
        if result.outcome is Outcome.OK:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return conversions.result_of(result, self._last_strike)

    def _cancel(self, goal: GoalHandle) -> CancelResponse:
        if goal is not self._goal or self._controller.state not in (
            State.AIMING,
            State.AIMED,
            State.ARMED,
        ):
            return CancelResponse.REJECT
        self._controller.disarm(steady_time(), 'canceled', Outcome.CANCELED)
        return CancelResponse.ACCEPT

    # --- outputs --------------------------------------------------------------------------------

    def _tick(self) -> None:
        now = steady_time()
        self._decision_time = self.get_clock().now()
        self._controller.receive_clock(1e-9 * self._decision_time.nanoseconds, now)
        self._controller.receive_other_drivers(self._other_drivers(), now)
        self._controller.tick(now)
        if self._controller.command:
            self._actuation.publish(self._command)
            self._incline.publish(self._angle)
        elevation = self._controller.measured_elevation(now)
        if elevation:
            angle, rate = map(np.atleast_1d, elevation)
            stamp = self.get_clock().now().to_msg()
            self._joints.publish(
                conversions.joints_message([self._incline_joint], angle, rate, stamp)
            )

    def _publish_command(self, command: Command) -> None:
        """
        Publish a new command, which `_tick` repeats.

        A trajectory has the stamp of the decision. So if this process is paused between the
        decision and the publication, the mechanism sees that the command is old.
        """
        name = conversions.command_name(self._name, command.number)
        if command.trajectory is None:
            self._command = conversions.stop_message(self._controller.position, self._names, name)
        else:
            self._command = conversions.trajectory_message(
                command.trajectory, self._names, self._decision_time.to_msg(), name
            )
            self._angle.data = self._controller.mechanism.incline_geometry.elevation(
                float(command.trajectory.positions[-1, INCLINE])
            )
        self._actuation.publish(self._command)

    def _other_drivers(self) -> list[str]:
        """Names of other nodes that publish commands; empty while the driver is not active."""
        topic = self._actuation.topic_name
        if self._inactive or self.count_publishers(topic) < 2:
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
        self._last_strike = conversions.strike_message(strike, parameters.table_header(self))
        self._strike.publish(self._last_strike)

    def _finish(self, result: Result) -> None:
        self._goal = None
        if self._ended:
            self._ended.set_result(result)

    def _state_message(self) -> CueState:
        return conversions.state_message(self._controller, self.get_clock().now().to_msg())

    def _load_machine_code(self) -> None:
        """Begin to load the code that other nodes have compiled, while nothing moves."""
        if self._controller.state is State.DISARMED:
            machine_code.load()

    def _publish_diagnostics(self) -> None:
        now = steady_time()
        health = conversions.health(self._controller, self._inactive, now)
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
            self._reminded = -math.inf
        elif now - self._reminded > REMINDER_PERIOD:
            self._reminded = now
            self.get_logger().warning(f'not ready: {"; ".join(wrong)}')


def _aborted(goal: GoalHandle, outcome: Outcome, reason: str) -> ExecuteShot.Result:
    """End a goal that has not begun; return its result."""
    goal.abort()
    return conversions.result_of(Result(outcome, reason, None), Strike())


def _answering(act: Callable[[Any], Decision]) -> Callable[[Any, Any], Any]:
    """Make the callback of a service that acts on the controller and answers with its decision."""

    def answer(request: Any, response: Any) -> Any:
        decision = act(request)
        response.success = decision.accepted
        response.message = decision.reason or decision.state.name
        return response

    return answer


def main(args: Sequence[str] | None = None) -> None:
    """Run the node."""
    run(CueDriver, 'cue_driver', args, CueDriver.leave, CueDriver.survive)


if __name__ == '__main__':
    main()
