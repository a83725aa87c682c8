"""
The cue's controller: goals and inputs go in, commands for the mechanism come out.

The controller uses neither middleware nor a clock of its own. Every call passes `now`, the time of
a steady clock [s]. Calls that pass a message also pass the time at which the message was written.
The controller acts on messages at once; it checks for time-outs and progress at every `tick`.
After a pause without calls, it trusts no message from before the pause. Every motion begins with
an event of the table in `safety`, for which the controller must be active at that moment.
"""

from collections import deque
from collections.abc import Callable, Collection, Hashable
from dataclasses import dataclass, field
import math

import numpy as np

from billiard_shot.cue.inputs import check_goal, check_stamp, ClockWatch, HeartbeatInput
from billiard_shot.cue.joint_trajectory import JointTrajectory, StrokeProfile
from billiard_shot.cue.mechanism import INCLINE, JOINTS, Mechanism, STROKE, UNITS
from billiard_shot.cue.model import forward_kinematics, TipPose
from billiard_shot.cue.plan import (
    aim_trajectory,
    GoalOutcome,
    hidden_balls,
    prepare_shot,
    PreparedShot,
    RefusedError,
    ShotPlan,
)
from billiard_shot.cue.safety import (
    BEFORE_STROKE,
    Condition,
    decide,
    LATCHED_STATES,
    MOVING,
    SafetyDecision,
    SafetyEvent,
    SafetyState,
)
from billiard_shot.perception.sightings import Balls, Heartbeat, TableSettings, TableWatch
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.errors import must_be
from billiard_shot.scene.fields import number

AVERAGED_FRACTION = 0.8
"""Last fraction of the distance at constant speed, over which the speed is averaged."""


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredStrike:
    """Measured strike: the pose of the tip as it met the ball, and its speed [m/s]."""

    tip: TipPose
    speed: float


@dataclass(slots=True)
class StrikeDetector:
    """
    Detects the strike in one stroke.

    `strike` is None until the cue has met the ball, and afterwards if nothing was measured just
    before; `missing` says that.
    """

    profile: StrokeProfile
    strike: MeasuredStrike | None = None
    has_met: bool = False  # whether the cue was measured where it meets the ball, or beyond
    _speeds: list[float] = field(default_factory=list)
    _joints: Array | None = None

    @property
    def missing(self) -> str:
        """Return why a strike was not measured; '' if it was, or if there was none."""
        if self.strike or not self.has_met:
            return ''
        needed = AVERAGED_FRACTION * self.profile.mechanism.steady_time
        return (
            f'the strike was not measured: no joint_states in the last {1e3 * needed:.3g} ms '
            'before it'
        )

    def update(self, position: Array, velocity: Array) -> bool:
        """Take measured joints (6,); return whether the cue has just met the ball."""
        if self.has_met:
            return False
        contact = self.profile.contact_at
        if position[STROKE] < contact:
            if position[STROKE] >= contact - AVERAGED_FRACTION * self.profile.steady_way:
                self._speeds.append(float(velocity[STROKE]))
                self._joints = position
            return False
        self.has_met = True
        if self._joints is not None:
            mechanism, joints = self.profile.mechanism, self._joints.copy()
            joints[STROKE] = contact
            speed = mechanism.alignment.speed(float(np.mean(self._speeds)))
            self.strike = MeasuredStrike(forward_kinematics(mechanism, joints), speed)
        return True


MIN_DURATION, LATEST_STOP = 0.05, 2.0
"""Range of the time-outs that end in a stop [s]; a later stop would be too late."""


@dataclass(frozen=True, slots=True)
class Settings(TableSettings):
    """
    Time-outs and tolerances of the controller, in addition to those of the table state.

    Parameters
    ----------
    estop_timeout : float
        If `estop` is silent for longer than this, it is an emergency stop [s].
    interlock_timeout : float
        If `interlock` is silent for longer than this, it counts as open [s].
    joint_states_timeout : float
        If `joint_states` is silent for longer than this, it is a fault [s].
    arm_timeout : float
        If the cue is armed for longer than this without firing, it disarms [s].
    settle_time : float
        Time from armed to the start of the stroke; below arm_timeout [s].
    max_goal_validity : float
        Longest time for which a goal may be valid [s].
    motion_timeout : float
        Longest allowed delay behind the commanded trajectory, start-up included; beyond it the
        driver faults [s].
    aim_tolerance : float
        Largest error of the position of a joint, relative to its range.
    brake_tolerance : float
        Largest distance by which the cue may overrun its planned stop; beyond it the driver
        faults [m].

    """

    estop_timeout: float = number('s', minimum=MIN_DURATION, maximum=LATEST_STOP, default=0.5)
    interlock_timeout: float = number('s', minimum=MIN_DURATION, maximum=LATEST_STOP, default=0.5)
    joint_states_timeout: float = number(
        's', minimum=MIN_DURATION, maximum=LATEST_STOP, default=0.5
    )
    arm_timeout: float = number('s', minimum=0.1, maximum=60.0, default=5.0)
    settle_time: float = number('s', minimum=0.0, maximum=10.0, default=0.1)
    max_goal_validity: float = number('s', minimum=1.0, maximum=3600.0, default=600.0)
    motion_timeout: float = number('s', minimum=0.1, maximum=30.0, default=2.0)
    aim_tolerance: float = number('', minimum=1e-9, maximum=0.01, default=2e-4)
    brake_tolerance: float = number('m', minimum=1e-4, maximum=0.02, default=0.005)

    @property
    def max_pause(self) -> float:
        """
        Longest time between two ticks after which the inputs are still trusted [s].

        If the controller has not run for longer, all earlier messages are stale.
        """
        return 0.5 * min(self.estop_timeout, self.interlock_timeout, self.joint_states_timeout)


@dataclass(frozen=True, slots=True, eq=False)
class Command:
    """
    Command for the mechanism: follow a trajectory, or stop.

    Until the time `whole` [s] the trajectory must not be cut: it is a stroke, which brakes before
    the cloth and draws the cue back.
    """

    trajectory: JointTrajectory | None  # None: stop
    whole: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """How a goal ended; `strike` is None if the cue met no ball, or if that was not measured."""

    outcome: GoalOutcome
    message: str
    has_met: bool = False  # whether the cue met the ball
    strike: MeasuredStrike | None = None


@dataclass(slots=True, eq=False)
class Execution:
    """
    A goal that is being executed.

    Times are those of the controller's clock, but `expiry` is that of the clock of goals [s].
    """

    shot: PreparedShot
    expires: float
    expiry: float
    detector: StrikeDetector
    armed_until: float = -math.inf
    fire_at: float = math.inf


OVERRUN = 0.1
"""Largest plausible overrun of a joint beyond its range, relative to the range."""

RESTING = 0.05
"""Largest speed at which a joint counts as being at rest, relative to its speed limit."""

REMEMBERED = 10_000
"""Number of shots that are not played again; the oldest is forgotten first."""

RECOVERY = 4.0
"""
Time after a pause during which no input is trusted [s].

Reliable middleware resends the messages and requests that a stopped process has missed; Fast DDS
does so every three seconds. After this time, everything sent before the end of the pause has
arrived.
"""


class Controller:
    """
    The cue's controller.

    Parameters
    ----------
    mechanism : Mechanism
    scene : Scene
        Scene whose cue is that of the mechanism, and guided.
    settings : Settings
    on_state : callable
        Called after every change of `state` and `reason`.
    on_command : callable
        Called with every new command, but not when a command is repeated.
    on_strike : callable
        Called when the cue has met the ball, with the measured strike; None if that is missing.
    on_result : callable
        Called with the result when a goal ends.

    """

    def __init__(
        self,
        mechanism: Mechanism,
        scene: Scene,
        settings: Settings,
        *,
        on_state: Callable[[], None] = lambda: None,
        on_command: Callable[[Command], None] = lambda _: None,
        on_strike: Callable[[MeasuredStrike | None], None] = lambda _: None,
        on_result: Callable[[Result], None] = lambda _: None,
    ) -> None:
        self.state, self.reason = SafetyState.DISARMED, 'started'
        self.inactive = 'the controller has not been activated'  # '': it is active
        self.estop = HeartbeatInput('estop', settings.estop_timeout, safe=False)
        self.interlock = HeartbeatInput('interlock', settings.interlock_timeout, safe=True)
        self.joints = Heartbeat('joint_states', settings.joint_states_timeout)
        self.missing_joints = ''
        self._commands_problem, self._commands_wait = '', False
        self.command: Command | None = None
        self._tell_state, self._tell_command = on_state, on_command
        self._tell_strike, self._tell_result = on_strike, on_result
        self._played: deque[str] = deque(maxlen=REMEMBERED)  # ids of shots
        self._started = math.inf  # first time of the clock of goals, or an earlier one if set back
        self.position = self.velocity = np.full(len(JOINTS), math.nan)
        self._execution: Execution | None = None
        self._begin = 0.0  # of the current trajectory
        self.configure(mechanism, scene, settings)

    def configure(self, mechanism: Mechanism, scene: Scene, settings: Settings) -> None:
        """
        Start over while nothing moves, perhaps with other settings, as described for the class.

        A latched state and the ids of played shots stay; older messages stay invalid.
        """
        self.mechanism, self._scene, self.settings = mechanism, scene, settings
        self.estop.set_timeout(settings.estop_timeout)
        self.interlock.set_timeout(settings.interlock_timeout)
        self.joints.timeout = settings.joint_states_timeout
        self.clock = ClockWatch('ROS clock', settings.max_pause)
        self.table = TableWatch(settings)
        self._last_tick = math.inf
        self._has_heard = False
        self.deaf_since = math.inf  # end of a pause, if nothing written later has been received
        ranges = [axis.max - axis.min for axis in mechanism.axes]
        self._near = settings.aim_tolerance * np.array(ranges)
        if self.state in LATCHED_STATES:
            self._stop()
        else:
            self.reason = 'started'

    def restore(self, state: SafetyState, reason: str) -> None:
        """Take a latched state from before this program started."""
        before = 'before this start: '
        self.state, self.reason = state, before + reason.removeprefix(before)

    def activate(self) -> None:
        """Allow motion from now on."""
        self.inactive = ''

    def deactivate(self, now: float, reason: str, ended: str) -> None:
        """
        Allow no motion from now on, for a reason; stop, and end the goal that is being executed.

        `ended` is the reason of the state in which that ends.
        """
        was_active, self.inactive = not self.inactive, reason
        if was_active:
            self._event(SafetyEvent.DISARM, now, ended)

    def problems(self, now: float) -> dict[str, str]:
        """Return the problem of each input and device that a shot needs; '' if it has none."""
        return {
            'node': self.inactive,
            'estop': self.estop.problem(now),
            'interlock': self.interlock.problem(now),
            'mechanism': self.mechanism_fault(now),
            'table': self.table.stale(self.clock.time, now, self._hidden()),
            'clock': self.clock.problem(now),
            'commands': self._commands_problem,
        }

    @property
    def shot_id(self) -> str:
        """Id of the shot that is being executed; '' if there is none."""
        return self._execution.shot.plan.shot_id if self._execution else ''

    def measured_elevation(self, now: float) -> tuple[float, float] | None:
        """Elevation of the cue [rad] and its rate [rad/s]; None if they are not known."""
        if self.mechanism_fault(now):
            return None
        mechanism, length = self.mechanism, float(self.position[INCLINE])
        rate = float(self.velocity[INCLINE]) / mechanism.length_per_elevation(length)
        return mechanism.elevation(length), rate

    # --- inputs ---------------------------------------------------------------------------------

    def receive_estop(
        self, pressed: bool, written: float, now: float, publisher: Hashable = None
    ) -> None:
        """Take the state of the emergency stop; if pressed, stop even if the message is old."""
        self._hear(written, now)
        self.estop.record(pressed, written, now, publisher)
        if pressed and self.state is not SafetyState.ESTOP:
            self._event(SafetyEvent.ESTOP, now, 'estop: pressed')

    def receive_interlock(
        self, safe: bool, written: float, now: float, publisher: Hashable = None
    ) -> None:
        """Take the state of the interlock; if not safe, stop even if the message is old."""
        self._hear(written, now)
        self.interlock.record(safe, written, now, publisher)
        self._watch_interlock(now)

    def receive_joints(self, position: Array, velocity: Array, written: float, now: float) -> None:
        """Take measured joint positions (6,) [m, rad] and velocities [per s]."""
        self._hear(written, now)
        if not self.joints.record(written, now):
            return
        self.position, self.velocity = position, velocity
        if self.state in MOVING and (problem := self._implausible_joint()):
            self.fail(now, problem)
        elif self.state is SafetyState.FIRING and self._execution:
            detector = self._execution.detector
            if detector.update(position, velocity):
                self._tell_strike(detector.strike)
            self._watch_brake(now)

    def receive_clock(self, time: float, now: float) -> None:
        """Take a reading of the clock of goals [s], 0 if it has not started; see `ClockWatch`."""
        self.clock.update(time, now)
        if time > 0.0:
            self._started = min(self._started, time)

    def receive_commands(self, problem: str, failure: str, wait: bool, now: float) -> None:
        """
        Take why no motion can be commanded, and why commands were not followed; '' for no reason.

        A failure is a fault in every state. While commands `wait` for an answer, no stroke begins.
        """
        self._commands_problem, self._commands_wait = problem, wait
        if failure and self.state is not SafetyState.FAULT:
            self.fail(now, failure)

    def receive_table(
        self, balls: Balls, picture: float, written: float, stamp_now: float, now: float
    ) -> None:
        """Take the balls on the table, as `TableWatch.record` does."""
        self._hear(written, now)
        self.table.record(balls, picture, written, stamp_now, now)

    def reject_table(self, reason: str, now: float) -> None:
        """Know the balls no longer, because a message about them was not valid."""
        self.table.reject(reason)
        self._give_up(now)

    # --- requests -------------------------------------------------------------------------------

    def execute(
        self,
        plan: ShotPlan,
        remaining: float,
        clock: Callable[[], float],
        *,
        allow_miscue: bool = False,
    ) -> None:
        """
        Begin to execute a plan; `on_result` is called when it ends.

        Parameters
        ----------
        plan : ShotPlan
        remaining : float
            Time for which the goal remains valid [s].
        clock : callable
            Reads the steady clock [s]. It is called again before the motion begins, because the
            preparation of a shot takes long.
        allow_miscue : bool
            Whether a stroke may be played in which the tip slides on the ball.

        Raises
        ------
        RefusedError
            If the goal is refused. Nothing has moved then.

        """
        now = clock()
        self._notice_pause(now)
        if self._execution:
            raise RefusedError(GoalOutcome.BUSY, f'shot {self.shot_id!r} is being executed')
        problems = self._problems(now) | {Condition.GOAL_VALID: ''}  # checked below
        decision = decide(self.state, SafetyEvent.AIM, problems)
        if not decision.accepted:
            raise RefusedError(GoalOutcome.NOT_READY, decision.reason)
        if moving := self._moving_joint():
            raise RefusedError(GoalOutcome.NOT_READY, moving)
        check_goal(plan.shot_id, remaining, self._played, self.settings.max_goal_validity)
        check_stamp(plan.made, self._started, self.clock.time + self.settings.stamp_tolerance)
        if problem := self.table.stale(self.clock.time, now):
            raise RefusedError(GoalOutcome.TABLE_UNKNOWN, problem)
        if problem := self.table.moved(plan.balls, is_aimed=False):
            raise RefusedError(GoalOutcome.TABLE_DIFFERS, problem)
        if problem := self.table.uncertain(plan.balls):
            raise RefusedError(GoalOutcome.TABLE_UNKNOWN, problem)
        shot = prepare_shot(self.mechanism, self._scene, plan, allow_miscue=allow_miscue)
        expires, expiry = now + remaining, self.clock.time + remaining
        now = clock()
        self._notice_pause(now)
        aim = aim_trajectory(self.mechanism, self.position, shot.aimed)
        self._execution = Execution(shot, expires, expiry, StrikeDetector(shot.profile))
        decision = self._event(SafetyEvent.AIM, now, f'shot {plan.shot_id!r}')
        if not decision.accepted:
            self._execution = None
            raise RefusedError(GoalOutcome.NOT_READY, decision.reason)
        self._played.append(plan.shot_id)
        self._start(aim, now)

    def arm(self, shot_id: str, now: float) -> SafetyDecision:
        """Allow the aimed shot to be fired, if `shot_id` names it; it fires after settling."""
        self._notice_pause(now)
        if self.inactive:  # the table would only say that no cue is aimed
            return SafetyDecision(False, self.state, f'arm: {self.inactive}')
        if self._execution and shot_id != self.shot_id:
            wrong = f'arm: shot_id {must_be(repr(self.shot_id), shot_id)}'
            return SafetyDecision(False, self.state, wrong)
        decision = self._event(SafetyEvent.ARM, now, 'armed')
        if decision.accepted and self._execution:
            self._execution.armed_until = now + self.settings.arm_timeout
            self._execution.fire_at = now + self.settings.settle_time
        return decision

    def disarm(
        self, now: float, reason: str, outcome: GoalOutcome | None = None
    ) -> SafetyDecision:
        """Stop all motion and return to DISARMED, unless ESTOP or FAULT is latched."""
        return self._event(SafetyEvent.DISARM, now, reason, outcome)

    def clear(self, now: float) -> SafetyDecision:
        """Leave ESTOP or FAULT, if its cause is gone."""
        self._notice_pause(now)
        return self._event(SafetyEvent.CLEAR, now, 'cleared')

    def fail(self, now: float, reason: str) -> None:
        """Stop all motion and latch FAULT."""
        self._event(SafetyEvent.FAIL, now, reason)

    # --- periodic work --------------------------------------------------------------------------

    def tick(self, now: float) -> None:
        """Check for time-outs and progress; to be called at a steady rate."""
        self._notice_pause(now)
        self._last_tick = now
        if self.state in MOVING:
            if problem := self.estop.problem(now):
                self._event(SafetyEvent.ESTOP, now, problem)
            self._watch_interlock(now)
        if self.state in MOVING and (
            problem := self.mechanism_fault(now) or self._commands_problem
        ):
            self.fail(now, problem)
        if self.state in BEFORE_STROKE and (problem := self.clock.problem(now)):
            self._event(SafetyEvent.INTERRUPTED, now, problem)
        self._give_up(now)
        if self._execution:
            self._progress(now, self._execution)

    def _notice_pause(self, now: float) -> None:
        """
        If the controller has not run for longer than `max_pause`, trust no earlier message.

        Messages and requests that waited during the pause arrive afterwards as if they were new.
        So an input is fresh again only once a message has been written some time after the pause.
        Until then requests are refused.
        """
        pause = now - self._last_tick
        if pause <= self.settings.max_pause:
            return
        self._last_tick = now
        if self._has_heard:
            self.deaf_since = now
        for each in (self.estop, self.interlock, self.joints, self.table.heartbeat):
            each.forget(now + RECOVERY)
        self._event(SafetyEvent.INTERRUPTED, now, f'this process did not run for {pause:.3g} s')

    def _hear(self, written: float, now: float) -> None:
        """Note that a message has been received."""
        self._notice_pause(now)
        self._has_heard = True
        if written > self.deaf_since:
            self.deaf_since = math.inf

    def _give_up(self, now: float) -> None:
        """Before the stroke: end a goal that is no longer valid."""
        if self._execution and self.state in BEFORE_STROKE:
            outcome, problem = self._goal_problem(now)
            if problem:
                self._event(SafetyEvent.EXPIRE, now, problem, outcome)

    def _progress(self, now: float, execution: Execution) -> None:
        """Enter the next state as soon as the motion of the current one has ended."""
        if self.state is SafetyState.AIMING:
            self._reach(now, SafetyEvent.REACH, 'waiting to be armed')
        elif self.state is SafetyState.ARMED:
            settled = (np.abs(self.position - execution.shot.aimed) <= self._near).all()
            if now >= execution.fire_at and settled and not self._commands_wait:
                fired = self._event(SafetyEvent.FIRE, now, 'striking')
                if fired.accepted:
                    stroke = execution.shot.stroke
                    self._start(stroke.trajectory, now, stroke.home)
        elif self.state is SafetyState.FIRING:
            overdue = now - self._begin - execution.shot.stroke.stop
            has_met = execution.detector.has_met
            if overdue >= 0.0 and has_met and self.velocity[STROKE] <= 0.01:
                self._event(SafetyEvent.BRAKED, now, 'drawing back')
            elif overdue > self.settings.motion_timeout:
                problem = 'stopped in time' if has_met else 'met the ball'
                self.fail(now, f'stroke: the cue has not {problem}')
        elif self.state is SafetyState.RETRACTING:
            done = '; '.join(filter(None, ('done', execution.detector.missing)))
            self._reach(now, SafetyEvent.HOME, done, GoalOutcome.OK)

    def _reach(
        self, now: float, event: SafetyEvent, reason: str, outcome: GoalOutcome | None = None
    ) -> None:
        """Note when the joints have reached the end of their trajectory; fault if they do not."""
        assert self.command
        assert self.command.trajectory
        target = self.command.trajectory.positions[-1]
        off = self.position - target
        errors = np.abs(off) / self._near
        overdue = now - self._begin - self.command.trajectory.duration
        if overdue >= 0.0 and errors.max() <= 1.0:
            self._event(event, now, reason, outcome)
        elif overdue > self.settings.motion_timeout:
            joint = int(errors.argmax())
            self.fail(
                now,
                f'{JOINTS[joint]}: {off[joint]:.3g} {UNITS[joint]} from where it should have been '
                f'{self.settings.motion_timeout:g} s ago',
            )

    def _watch_interlock(self, now: float) -> None:
        if self.state in MOVING and (problem := self.interlock.problem(now)):
            self._event(SafetyEvent.INTERRUPTED, now, problem)

    def _watch_brake(self, now: float) -> None:
        assert self._execution
        profile = self._execution.shot.profile
        beyond = float(self.position[STROKE]) - max(profile.stop_at, profile.leave_at)
        if beyond > self.settings.brake_tolerance:
            self.fail(
                now,
                f'stroke: the cue is {1e3 * beyond:.3g} mm beyond where it should have '
                'stopped: the brake was late, or there was no ball',
            )

    # --- decisions ------------------------------------------------------------------------------

    def _event(
        self, event: SafetyEvent, now: float, reason: str, outcome: GoalOutcome | None = None
    ) -> SafetyDecision:
        """
        Enter the next state of the table; a state without motion stops the mechanism.

        The goal ends with `outcome`, by default that with the name of the state: DISARMED, ESTOP
        or FAULT.
        """
        decision = decide(self.state, event, self._problems(now))
        if not decision.accepted:
            return decision
        self.state, self.reason = decision.state, reason
        if self.state not in MOVING:
            self._stop()
        self._tell_state()
        if self._execution and self.state not in MOVING:
            execution, self._execution = self._execution, None
            if outcome is None:
                outcome = GoalOutcome[self.state.name]
            detector = execution.detector
            self._tell_result(Result(outcome, reason, detector.has_met, detector.strike))
        return decision

    def _start(self, trajectory: JointTrajectory, now: float, whole: float = 0.0) -> None:
        self._begin = now
        self.command = Command(trajectory, whole)
        self._tell_command(self.command)

    def _stop(self) -> None:
        """Command a stop, which is repeated if the state is latched."""
        stop = Command(None)
        self.command = None if self.state is SafetyState.DISARMED else stop
        self._tell_command(stop)

    def _problems(self, now: float) -> dict[Condition, str]:
        """Why conditions do not hold; '' for those that do."""
        return {
            Condition.ACTIVE: self.inactive,
            Condition.ESTOP_FRESH: self.estop.problem(now),
            Condition.INTERLOCK_FRESH: self.interlock.problem(now),
            Condition.MECHANISM_HEALTHY: self.mechanism_fault(now),
            Condition.COMMANDS_FOLLOWED: self._commands_problem,
            Condition.CLOCK_RUNS: self.clock.problem(now),
            Condition.GOAL_VALID: self._goal_problem(now)[1],
        }

    def _goal_problem(self, now: float) -> tuple[GoalOutcome, str]:
        """Find why the goal is no longer valid, or '', and the outcome that it has then."""
        execution = self._execution
        if execution is None:
            return GoalOutcome.DISARMED, 'no goal'
        planned, stamp_now = execution.shot.plan.balls, self.clock.time
        if now > execution.expires or stamp_now > execution.expiry:
            return GoalOutcome.EXPIRED, 'the goal has expired'
        if problem := self.table.stale(stamp_now, now, self._hidden()):
            return GoalOutcome.TABLE_STALE, problem
        if problem := self.table.moved(planned, is_aimed=True):
            return GoalOutcome.TABLE_MOVED, problem
        if problem := self.table.uncertain(planned):
            return GoalOutcome.TABLE_STALE, problem
        if self.state is SafetyState.ARMED and now > execution.armed_until:
            limit = self.settings.arm_timeout
            return GoalOutcome.ARM_TIMEOUT, f'armed for more than {limit:g} s without firing'
        return GoalOutcome.OK, ''

    def _hidden(self) -> Collection[str]:
        """Names of the balls that the mechanism may hide; if it is armed, of those beside it."""
        if self._execution is None:
            return ()
        shot = self._execution.shot
        if self.state is SafetyState.ARMED:
            return hidden_balls(shot, self.settings.hidden_width)
        return shot.plan.balls.keys()

    def mechanism_fault(self, now: float) -> str:
        """Return why the mechanism is not to be trusted; '' if it is."""
        stale = self.joints.stale(now)
        if stale and self.missing_joints:
            return f'{stale} (without {self.missing_joints})'
        return stale or self._implausible_joint()

    def _implausible_joint(self) -> str:
        """Return which joint cannot be where it was measured; '' if all can."""
        for name, unit, axis, position, velocity in zip(
            JOINTS, UNITS, self.mechanism.axes, self.position, self.velocity, strict=True
        ):
            if math.isfinite(position) and math.isnan(velocity):
                return f'joint_states: {name} has no velocity, which the driver needs'
            if not (math.isfinite(position) and math.isfinite(velocity)):
                return f'joint_states: {name} is at {position} with velocity {velocity}'
            overrun = OVERRUN * (axis.max - axis.min)
            if not axis.min - overrun <= position <= axis.max + overrun:
                return (
                    f'joint_states: {name} is at {position:.4g} {unit}, which is not between '
                    f'{axis.min - overrun:.4g} and {axis.max + overrun:.4g}'
                )
        shortest, longest = self.mechanism.incline_geometry.sides
        length = float(self.position[INCLINE])
        if not shortest < length < longest:
            return (
                f'joint_states: incline is at {length:.4g} m, which is not between {shortest:g} '
                f'and {longest:g} m'
            )
        return ''

    def _moving_joint(self) -> str:
        """Return which joint still moves; '' if all are at rest, where a trajectory must begin."""
        for name, unit, axis, velocity in zip(
            JOINTS, UNITS, self.mechanism.axes, self.velocity, strict=True
        ):
            if abs(velocity) > RESTING * axis.speed:
                return f'{name} still moves, at {velocity:.3g} {unit}/s'
        return ''
