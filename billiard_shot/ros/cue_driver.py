"""The node `cue_driver`: plays shots with the mechanical cue, and stops it where it must."""
from collections.abc import Callable, Sequence
from time import monotonic

from billiard_shot_msgs.action import ExecuteShot
from billiard_shot_msgs.msg import CueState, Strike, TableState
from diagnostic_msgs.msg import DiagnosticArray
import numpy as np
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.task import Future
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
from billiard_shot.ros.running import be_urgent, EVERY_STATE, LATCHED, run, warm_up

SUCCESS = TransitionCallbackReturn.SUCCESS

INACTIVE = 'the node is not active'


class CueDriver(LifecycleNode):
    """
    Lifecycle node with the action `execute_shot` (billiard_shot_msgs/action/ExecuteShot).

    Publishes `~/incline_angle` (std_msgs/msg/Float64), the commanded elevation in radians;
    `~/actuation` (trajectory_msgs/msg/JointTrajectory), which is repeated as long as it holds,
    for the mechanism stops when commands cease; `~/state` (billiard_shot_msgs/msg/CueState),
    latched;
    `~/strike` (billiard_shot_msgs/msg/Strike), what was measured; the elevation of the cue as a
    joint in `joint_states`; and `/diagnostics`. Services `~/arm`, `~/disarm` and `~/clear_fault`
    (std_srvs/srv/Trigger). Subscribes to `joint_states`, `table_state`, and to `estop` (true:
    stop) and `interlock` (true: safe), std_msgs/msg/Bool, which have to be repeated: silence means
    stop.
    Its parameters are `cue_parameters.CUE_DRIVER`; but for the topics, they are read whenever it
    is configured.
    """

    def __init__(self) -> None:
        super().__init__('cue_driver')
        parameters.declare(self, cue_parameters.CUE_DRIVER)
        be_urgent(self, self.get_parameter('niceness').value)
        self._active = False
        self._goal: ServerGoalHandle | None = None
        self._ended: Future | None = None
        self._command = JointTrajectory()
        self._angle = Float64()
        topic = {name: self.get_parameter(f'{name}_topic').value
                 for name in ('incline', 'actuation')}
        self._incline = self.create_lifecycle_publisher(Float64, topic['incline'], 10)
        self._actuation = self.create_lifecycle_publisher(JointTrajectory, topic['actuation'], 10)
        self._state = self.create_publisher(CueState, '~/state', EVERY_STATE)
        self._strike = self.create_publisher(Strike, '~/strike', 10)
        self._joints = self.create_publisher(JointState, 'joint_states', 10)
        self._diagnostics = self.create_publisher(DiagnosticArray, '/diagnostics', 10)
        self._configure()

        self.create_subscription(Bool, 'estop', lambda message: self._controller.hear_estop(
            message.data, monotonic()), 10)
        self.create_subscription(Bool, 'interlock', lambda message: (
            self._controller.hear_interlock(message.data, monotonic())), 10)
        self.create_subscription(JointState, 'joint_states', self._hear_joints, 50)
        self.create_subscription(TableState, 'table_state', self._hear_table, LATCHED)
        self.create_service(Trigger, '~/arm', self._arm)
        self.create_service(Trigger, '~/disarm', _answering(
            lambda: self._controller.disarm(monotonic(), 'disarmed by service')))
        self.create_service(Trigger, '~/clear_fault', _answering(
            lambda: self._controller.clear(monotonic())))
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(self.get_parameter('period').value, self._tick, clock=steady)
        self.create_timer(1.0, self._diagnose, clock=steady)
        self._server = ActionServer(
            self, ExecuteShot, 'execute_shot', self._execute, cancel_callback=self._cancel)
        if self.get_parameter('autostart').value:
            self.trigger_configure()
            self.trigger_activate()

    # --- life -----------------------------------------------------------------------------------

    def _configure(self) -> None:
        """Take over the parameters, all checked by now."""
        def value(name: str) -> object:
            return self.get_parameter(name).value

        self._names, self._incline_joint = value('joint_names'), value('incline_joint')
        scene = cue_parameters.guided_scene(value('scene'))
        warm_up(scene, other_balls=True)
        self._controller = Controller(
            Mechanism.load(value('mechanism')), scene, cue_parameters.settings_of(self),
            on_state=self._tell_state, on_command=self._give, on_strike=self._tell_strike,
            on_result=self._end)

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Start over with the parameters as they are now."""
        self._configure()
        self._tell_state()
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """From now on goals are executed."""
        result = super().on_activate(state)
        self._active = result is SUCCESS
        self.get_logger().info(f'ready: action {self.resolve_topic_name("execute_shot")}')
        return result

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Disarm, which stops the mechanism, and execute no more goals."""
        self._controller.disarm(monotonic(), 'deactivated')
        self._active = False
        return super().on_deactivate(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Disarm first, whatever is going on."""
        if self._active:
            self.on_deactivate(state)
        return super().on_shutdown(state)

    # --- what it hears and is asked for ---------------------------------------------------------

    def _hear_joints(self, message: JointState) -> None:
        joints = conversions.joints_of(message, self._names)
        if joints:
            self._controller.hear_joints(*joints, monotonic())

    def _hear_table(self, message: TableState) -> None:
        try:
            self._controller.hear_table(conversions.balls_of(message.balls))
        except RefusedError as error:
            self.get_logger().error(f'ignored a table_state: {error}')

    def _arm(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        return _answer(response, self._controller.arm(monotonic()) if self._active else Decision(
            False, self._controller.state, f'arm: {INACTIVE}'))

    async def _execute(self, goal: ServerGoalHandle) -> ExecuteShot.Result:
        now = self.get_clock().now().to_msg()
        try:
            if not self._active:
                raise RefusedError(Outcome.NOT_READY, INACTIVE)
            self._controller.execute(conversions.order_of(goal.request, now), monotonic())
        except RefusedError as error:
            self.get_logger().warning(f'refused: {error.outcome.name}: {error}')
            goal.abort()
            return conversions.result_of(Result(error.outcome, str(error), None), now)
        self._goal, self._ended = goal, Future(executor=self.executor)
        goal.publish_feedback(ExecuteShot.Feedback(state=self._state_message()))
        result: Result = await self._ended
        if result.outcome is Outcome.OK:
            goal.succeed()
        elif goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return conversions.result_of(result, self.get_clock().now().to_msg())

    def _cancel(self, goal: ServerGoalHandle) -> CancelResponse:
        if goal is not self._goal or self._controller.state not in (
                State.AIMING, State.AIMED, State.ARMED):
            return CancelResponse.REJECT
        self._controller.disarm(monotonic(), 'canceled', Outcome.CANCELED)
        return CancelResponse.ACCEPT

    # --- what it says ---------------------------------------------------------------------------

    def _tick(self) -> None:
        now = monotonic()
        self._controller.tick(now)
        if self._controller.command:
            self._actuation.publish(self._command)
            self._incline.publish(self._angle)
        elevation = self._controller.measured_elevation(now)
        if elevation:
            self._joints.publish(conversions.joints_message(
                [self._incline_joint], *map(np.atleast_1d, elevation),
                self.get_clock().now().to_msg()))

    def _give(self, command: Command) -> None:
        """Publish a new command, which `_tick` repeats."""
        if command.path is None:
            self._command = conversions.stop_message(self._controller.position, self._names)
        else:
            self._command = conversions.trajectory_message(
                command.path, self._names, self.get_clock().now().to_msg())
            self._angle.data = self._controller.mechanism.triangle.elevation(
                float(command.path.positions[-1, INCLINE]))
        self._actuation.publish(self._command)

    def _tell_state(self) -> None:
        message = self._state_message()
        self._state.publish(message)
        self.get_logger().info(f'{self._controller.state.name}: {message.reason}')
        if self._goal:
            self._goal.publish_feedback(ExecuteShot.Feedback(state=message))

    def _tell_strike(self, strike: MeasuredStrike) -> None:
        self._strike.publish(
            conversions.strike_message(strike, self.get_clock().now().to_msg()))

    def _end(self, result: Result) -> None:
        self._goal = None
        if self._ended:
            self._ended.set_result(result)

    def _state_message(self) -> CueState:
        return conversions.state_message(self._controller, self.get_clock().now().to_msg())

    def _diagnose(self) -> None:
        self._diagnostics.publish(conversions.diagnostics_message(
            self.get_fully_qualified_name(), self._controller, self._active, monotonic(),
            self.get_clock().now().to_msg()))


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
