"""
The cue's controller: goals and inputs go in, commands for the mechanism come out.

The controller uses neither middleware nor a clock of its own. Every call passes `now`, the time of
a steady clock [s]. Calls that pass a message also pass the time at which the message was written.
The controller acts on messages at once; it checks for time-outs and progress at every `tick`.
After a pause without calls, it trusts no message from before the pause.
"""

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
import math
from typing import Any

import numpy as np

from billiard_shot.cue.clock import ClockWatch
from billiard_shot.cue.execution import Command, Execution, Result, Settings
from billiard_shot.cue.goals import check_goal, remember
from billiard_shot.cue.inputs import Heartbeat, HeartbeatInput
from billiard_shot.cue.joint_trajectory import JointTrajectory
from billiard_shot.cue.measurement import MeasuredStrike, StrikeDetector
from billiard_shot.cue.mechanism import INCLINE, JOINTS, Mechanism, STROKE, UNITS
from billiard_shot.cue.outcome import GoalOutcome, RefusedError
from billiard_shot.cue.plan import aim_trajectory, prepare_shot, ShotPlan
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
from billiard_shot.cue.sightings import Balls
from billiard_shot.cue.table_watch import TableWatch
from billiard_shot.records import Array
from billiard_shot.scene import Scene

OVERRUN = 0.1
"""Largest plausible overrun of a joint beyond its range, relative to the range."""

RESTING = 0.05
"""Largest speed at which a joint counts as being at rest, relative to its speed limit."""

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
        Called with every measured strike.
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
        on_strike: Callable[[MeasuredStrike], None] = lambda _: None,
        on_result: Callable[[Result], None] = lambda _: None,
    ) -> None:
        self.state = SafetyState.DISARMED
        self.reason = 'started'
        self.estop = HeartbeatInput('estop', settings.estop_timeout, safe=False)
        self.interlock = HeartbeatInput('interlock', settings.interlock_timeout, safe=True)
        self.joints = Heartbeat('joint_states', settings.joint_states_timeout)
        self.clock = ClockWatch('ROS clock', settings.max_pause)
        self.missing_joints = self.controller_problem = ''
        self.other_drivers = ''
        self.command: Command | None = None
        self.mechanism = mechanism
        self._scene, self._settings = scene, settings
        self._tell_state, self._tell_command = on_state, on_command
        self._tell_strike, self._tell_result = on_strike, on_result
        self._played: dict[str, None] = {}  # ids of shots, in their order
        self.table = TableWatch(settings)
        self.position = self.velocity = np.full(len(JOINTS), math.nan)
        self._last_tick = math.inf
        self._has_heard = False
        self.deaf_since = math.inf  # end of a pause, if nothing written later has been received
        self._execution: Execution | None = None
        self._begin = 0.0  # of the current trajectory
        self._number = 0  # of the last command
        ranges = [axis.max - axis.min for axis in mechanism.axes]
        self._near = settings.aim_tolerance * np.array(ranges)

    @property
    def max_pause(self) -> float:
        """Longest time between two ticks after which the inputs are still trusted [s]."""
        return self._settings.max_pause

    def table_problem(self, now: float) -> str:
        """Reason why the positions of the balls are not known; '' if they are known."""
        if self.state in MOVING:
            return self.table.stale_while_aimed(self.clock.time, now)
        return self.table.stale(self.clock.time, now)

    @property
    def shot_id(self) -> str:
        """Id of the shot that is being executed; '' if there is none."""
        return self._execution.shot.plan.shot_id if self._execution else ''

    def measured_elevation(self, now: float) -> tuple[float, float] | None:
        """Elevation of the cue [rad] and its rate [rad/s]; None if they are not known."""
        if self.mechanism_fault(now):
            return None
        geometry, length = self.mechanism.incline_geometry, float(self.position[INCLINE])
        rate = float(self.velocity[INCLINE]) / geometry.length_per_elevation(length)
        return geometry.elevation(length), rate

    # --- inputs ---------------------------------------------------------------------------------

    def receive_estop(
        self, pressed: bool, written: float, now: float, publisher: Hashable = None
    ) -> None:
        """Take the state of the emergency stop; if pressed, stop even if the message is old."""
        self._hear(written, now)
        self.estop.record(pressed, written, now, publisher)
        if pressed and self.state is not SafetyState.ESTOP:
            self._event(SafetyEvent.ESTOP, now, 'estop: pressed', GoalOutcome.ESTOP)

    def receive_interlock(
        self, safe: bool, written: float, now: float, publisher: Hashable = None
    ) -> None:
        """Take the state of the interlock; if not safe, stop even if the message is old."""
        self._hear(written, now)
        self.interlock.record(safe, written, now, publisher)
        self._watch_interlock(now)

    def receive_publishers(
        self, estop: Mapping[Any, str], interlock: Mapping[Any, str], now: float
    ) -> None:
        """
        Take the living publishers of both safety inputs, with the names of their nodes.

        Their keys are the publishers of the calls above.
        """
        self.estop.keep(estop, now)
        self.interlock.keep(interlock, now)

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
            if detector.update(position, velocity) and detector.strike:
                self._tell_strike(detector.strike)
            self._watch_brake(now)

    def receive_clock(self, time: float, now: float) -> None:
        """Take a reading of the clock of goals' expiries [s]; if it fails, no stroke begins."""
        self.clock.update(time, now)

    def receive_other_drivers(self, names: Sequence[str], now: float) -> None:
        """Take the names of other nodes that command the mechanism; any such node is a fault."""
        self.other_drivers = (
            f'another node commands the mechanism: {", ".join(names)}' if names else ''
        )
        if names and self.state is not SafetyState.FAULT:
            self.fail(now, self.other_drivers)

    def receive_table(self, balls: Balls, written: float, stamp_now: float, now: float) -> None:
        """Take the balls on the table, as `TableWatch.record` does."""
        self._hear(written, now)
        self.table.record(balls, written, stamp_now, now)

    def reject_table(self, reason: str, now: float) -> None:
        """Know the balls no longer, because a message about them was not valid."""
        self.table.reject(reason)
        if self._execution and self.state in BEFORE_STROKE:
            self._give_up(now, self._execution)

    # --- requests -------------------------------------------------------------------------------

    def execute(self, plan: ShotPlan, remaining: float, clock: Callable[[], float]) -> None:
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

        Raises
        ------
        RefusedError
            If the goal is refused. Nothing has moved then.

        """
        now = clock()
        self._notice_pause(now)
        if self._execution:
            raise RefusedError(
                GoalOutcome.BUSY, f'shot {self._execution.shot.plan.shot_id!r} is being executed'
            )
        decision = self._decide(SafetyEvent.AIM, now, goal_valid=True)
        if not decision.accepted:
            raise RefusedError(GoalOutcome.NOT_READY, decision.reason)
        if moving := self._moving_joint():
            raise RefusedError(GoalOutcome.NOT_READY, moving)
        check_goal(plan.shot_id, remaining, self._played, self._settings.max_goal_validity)
        if problem := self.table_problem(now):
            raise RefusedError(GoalOutcome.TABLE_UNKNOWN, problem)
        if problem := self.table.moved(plan.balls):
            raise RefusedError(GoalOutcome.TABLE_DIFFERS, problem)
        shot = prepare_shot(self.mechanism, self._scene, plan)
        expires, expiry = now + remaining, self.clock.time + remaining
        now = clock()
        self._notice_pause(now)
        aim = aim_trajectory(self.mechanism, self.position, shot.aimed)
        self._execution = Execution(
            shot, expires, expiry, StrikeDetector(self.mechanism, shot.profile, plan.shot_id)
        )
        decision = self._event(SafetyEvent.AIM, now, f'shot {plan.shot_id!r}')
        if not decision.accepted:
            self._execution = None
            raise RefusedError(GoalOutcome.NOT_READY, decision.reason)
        remember(plan.shot_id, self._played)
        self._start(aim, now)

    def arm(self, shot_id: str, now: float) -> SafetyDecision:
        """Allow the aimed shot to be fired, if `shot_id` names it; it fires after settling."""
        self._notice_pause(now)
        if self._execution and shot_id != self.shot_id:
            return SafetyDecision(
                False, self.state, f'arm: shot_id must be {self.shot_id!r}, got {shot_id!r}'
            )
        decision = self._event(SafetyEvent.ARM, now, 'armed')
        if decision.accepted and self._execution:
            self._execution.armed_until = now + self._settings.arm_timeout
            self._execution.fire_at = now + self._settings.settle_time
        return decision

    def disarm(
        self, now: float, reason: str, outcome: GoalOutcome = GoalOutcome.DISARMED
    ) -> SafetyDecision:
        """Stop all motion and return to DISARMED, unless ESTOP or FAULT is latched."""
        return self._event(SafetyEvent.DISARM, now, reason, outcome)

    def clear(self, now: float) -> SafetyDecision:
        """Leave ESTOP or FAULT, if its cause is gone."""
        self._notice_pause(now)
        return self._event(SafetyEvent.CLEAR, now, 'cleared')

    def fail(self, now: float, reason: str) -> None:
        """Stop all motion and latch FAULT."""
        self._event(SafetyEvent.FAIL, now, reason, GoalOutcome.FAULT)

    def take_over(self, before: 'Controller') -> None:
        """
        Take over the state that new settings must not reset.

        It consists of a latched state, the distrust of earlier messages, and the used goals.
        """
        self._played = before._played
        self.estop.take_over(before.estop)
        self.interlock.take_over(before.interlock)
        self.joints.take_over(before.joints)
        self.position, self.velocity = before.position, before.velocity
        if before.state in LATCHED_STATES:
            self.state, self.reason = before.state, before.reason
            self._stop()

    # --- periodic work --------------------------------------------------------------------------

    def tick(self, now: float) -> None:
        """Check for time-outs and progress; to be called at a steady rate."""
        self._notice_pause(now)
        self._last_tick = now
        if self.state in MOVING:
            if problem := self.estop.problem(now):
                self._event(SafetyEvent.ESTOP, now, problem, GoalOutcome.ESTOP)
            self._watch_interlock(now)
        if self.state in MOVING and (problem := self.mechanism_fault(now)):
            self.fail(now, problem)
        if self.state in BEFORE_STROKE and (problem := self.clock.problem(now)):
            self._event(SafetyEvent.INTERRUPTED, now, problem, GoalOutcome.DISARMED)
        if self._execution:
            {
                SafetyState.AIMING: self._aim,
                SafetyState.AIMED: self._wait,
                SafetyState.ARMED: self._fire,
                SafetyState.FIRING: self._brake,
                SafetyState.RETRACTING: self._retract,
            }[self.state](now, self._execution)

    def _notice_pause(self, now: float) -> None:
        """
        If the controller has not run for longer than `max_pause`, trust no earlier message.

        Messages and requests that waited during the pause arrive afterwards as if they were new.
        So an input is fresh again only once a message has been written some time after the pause.
        Until then requests are refused.
        """
        pause = now - self._last_tick
        if pause <= self._settings.max_pause:
            return
        self._last_tick = now
        if self._has_heard:
            self.deaf_since = now
        for each in (self.estop, self.interlock, self.joints, self.table.heartbeat):
            each.forget(now + RECOVERY)
        outcome = GoalOutcome.DISARMED if self.state in BEFORE_STROKE else GoalOutcome.FAULT
        self._event(
            SafetyEvent.INTERRUPTED, now, f'this process did not run for {pause:.3g} s', outcome
        )

    def _hear(self, written: float, now: float) -> None:
        """Note that a message has been received."""
        self._notice_pause(now)
        self._has_heard = True
        if written > self.deaf_since:
            self.deaf_since = math.inf

    def _aim(self, now: float, execution: Execution) -> None:
        off = np.abs(self.position - execution.shot.aimed) / self._near
        if self._give_up(now, execution):
            return
        overdue = self._overdue(now)
        if overdue >= 0.0 and off.max() <= 1.0:
            self._event(SafetyEvent.REACH, now, 'waiting to be armed')
        elif overdue > self._settings.motion_timeout:
            self.fail(now, self._stuck(int(off.argmax()), execution.shot.aimed))

    def _wait(self, now: float, execution: Execution) -> None:
        self._give_up(now, execution)

    def _fire(self, now: float, execution: Execution) -> None:
        if self._give_up(now, execution):
            return
        if now > execution.armed_until:
            self._event(
                SafetyEvent.EXPIRE,
                now,
                (f'armed for more than {self._settings.arm_timeout:g} s without firing'),
                GoalOutcome.ARM_TIMEOUT,
            )
            return
        settled = (np.abs(self.position - execution.shot.aimed) <= self._near).all()
        if (
            now >= execution.fire_at
            and settled
            and self._event(SafetyEvent.FIRE, now, 'striking').accepted
        ):
            self._start(execution.shot.stroke.trajectory, now, execution.shot.stroke.home)

    def _brake(self, now: float, execution: Execution) -> None:
        overdue = now - self._begin - execution.shot.stroke.stop
        if overdue < 0.0:
            return
        if execution.detector.strike and self.velocity[STROKE] <= 0.01:
            self._event(SafetyEvent.BRAKED, now, 'drawing back')
        elif overdue > self._settings.motion_timeout:
            self.fail(now, 'stroke: the cue has not met the ball and stopped in time')

    def _retract(self, now: float, execution: Execution) -> None:
        home = execution.shot.stroke.trajectory.positions[-1]
        off = np.abs(self.position - home) / self._near
        overdue = self._overdue(now)
        if overdue >= 0.0 and off.max() <= 1.0:
            self._event(SafetyEvent.HOME, now, 'done')
        elif overdue > self._settings.motion_timeout:
            self.fail(now, self._stuck(int(off.argmax()), home))

    def _watch_interlock(self, now: float) -> None:
        if self.state in MOVING and (problem := self.interlock.problem(now)):
            outcome = (
                GoalOutcome.FAULT
                if self.state in (SafetyState.FIRING, SafetyState.RETRACTING)
                else GoalOutcome.DISARMED
            )
            self._event(SafetyEvent.INTERLOCK_LOST, now, problem, outcome)

    def _watch_brake(self, now: float) -> None:
        assert self._execution
        profile = self._execution.shot.profile
        beyond = float(self.position[STROKE]) - max(profile.stop_at, profile.leave_at)
        if beyond > self._settings.brake_tolerance:
            self.fail(
                now,
                f'stroke: the cue is {1e3 * beyond:.3g} mm beyond where it should have '
                'stopped: the brake was late, or there was no ball',
            )

    def _give_up(self, now: float, execution: Execution) -> bool:
        """End the goal if its conditions do not hold any more; return whether it has ended."""
        for outcome, problem in self._goal_problems(now, execution):
            if problem:
                self._event(SafetyEvent.EXPIRE, now, problem, outcome)
                return True
        return False

    # --- decisions ------------------------------------------------------------------------------

    def _event(
        self, event: SafetyEvent, now: float, reason: str, outcome: GoalOutcome = GoalOutcome.OK
    ) -> SafetyDecision:
        """Enter the next state of the table; a state without motion stops the mechanism."""
        decision = self._decide(event, now)
        if not decision.accepted:
            return decision
        self.state, self.reason = decision.state, reason
        if self.state not in MOVING:
            self._stop()
        self._tell_state()
        if self._execution and self.state not in MOVING:
            execution, self._execution = self._execution, None
            self._tell_result(Result(outcome, reason, execution.detector.strike))
        return decision

    def _stop(self) -> None:
        """Command a stop, which is repeated if the state is latched."""
        self._number += 1
        stop = Command(self._number, None)
        self.command = None if self.state is SafetyState.DISARMED else stop
        self._tell_command(stop)

    def _decide(self, event: SafetyEvent, now: float, goal_valid: bool = False) -> SafetyDecision:
        execution = self._execution
        problems = {
            Condition.ESTOP_FRESH: self.estop.problem(now),
            Condition.INTERLOCK_FRESH: self.interlock.problem(now),
            Condition.MECHANISM_HEALTHY: self.mechanism_fault(now),
            Condition.ALONE: self.other_drivers,
            Condition.CLOCK_RUNS: self.clock.problem(now),
            Condition.ARM_VALID: '' if execution and now <= execution.armed_until else 'not armed',
            Condition.GOAL_VALID: ''
            if goal_valid
            else 'no goal'
            if execution is None
            else next(
                (problem for _, problem in self._goal_problems(now, execution) if problem), ''
            ),
        }
        decision = decide(
            self.state, event, {name for name, problem in problems.items() if not problem}
        )
        why = '; '.join(problems[name] for name in decision.missing)
        if not why:
            return decision
        return replace(decision, reason=f'{decision.reason} ({why})')

    def _goal_problems(
        self, now: float, execution: Execution
    ) -> Iterator[tuple[GoalOutcome, str]]:
        """Yield why a goal is no longer valid, or '', with the outcome that it has then."""
        expired = execution.has_expired(now, self.clock.time)
        yield GoalOutcome.EXPIRED, 'the goal has expired' if expired else ''
        yield GoalOutcome.TABLE_STALE, self.table.stale_while_aimed(self.clock.time, now)
        yield GoalOutcome.TABLE_MOVED, self.table.moved_while_aimed(execution.shot.plan.balls)

    def mechanism_fault(self, now: float) -> str:
        """Return why the mechanism is not to be trusted; '' if it is."""
        if self.controller_problem:
            return self.controller_problem
        stale = self.joints.stale(now)
        if stale and self.missing_joints:
            return f'{stale} (without {self.missing_joints})'
        return stale or self._implausible_joint()

    def _implausible_joint(self) -> str:
        """Return which joint cannot be where it was measured; '' if all can."""
        for name, unit, axis, position, velocity in zip(
            JOINTS, UNITS, self.mechanism.axes, self.position, self.velocity, strict=True
        ):
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

    def _overdue(self, now: float) -> float:
        """Time since the end of the current trajectory [s]; negative before its end."""
        assert self.command
        assert self.command.trajectory
        return now - self._begin - self.command.trajectory.duration

    def _stuck(self, joint: int, target: Array) -> str:
        off = float(self.position[joint] - target[joint])
        return (
            f'{JOINTS[joint]}: {off:.3g} {UNITS[joint]} from where it should have been '
            f'{self._settings.motion_timeout:g} s ago'
        )

    def _start(self, trajectory: JointTrajectory, now: float, whole: float = 0.0) -> None:
        self._number += 1
        self._begin = now
        self.command = Command(self._number, trajectory, whole)
        self._tell_command(self.command)
