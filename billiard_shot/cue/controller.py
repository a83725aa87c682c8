"""
The cue's controller: orders and inputs go in, commands for the mechanism come out.

It knows no middleware and no clock: every call brings the time `now` of a steady clock [s] and the
time on that clock at which a message was written. It acts on messages at once, and on silence and
progress at every `tick`. After a pause without calls it trusts nothing that it heard before.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
import math

import numpy as np

from billiard_shot.cue.clock import ClockWatch
from billiard_shot.cue.inputs import Heartbeat, Input
from billiard_shot.cue.job import Command, Job, Result, Settings
from billiard_shot.cue.measurement import Strike, StrokeWatch
from billiard_shot.cue.mechanism import INCLINE, JOINTS, Mechanism, STROKE, UNITS
from billiard_shot.cue.orders import Balls, moved, Order, OrderBook
from billiard_shot.cue.outcome import Outcome, RefusedError
from billiard_shot.cue.path import Array, Path
from billiard_shot.cue.plan import aim_path, prepare
from billiard_shot.cue.safety import (
    BEFORE_STROKE,
    Condition,
    decide,
    Decision,
    Event,
    MOVING,
    State,
)
from billiard_shot.scene import Scene

RECOVERY = 4.0
"""
For how long nothing is trusted after a pause [s].

A reliable middleware repeats messages and requests that a stopped process has missed; Fast DDS
does so every three seconds. After this time all that was sent before the pause ended has come in.
"""


class Controller:
    """
    The cue's controller.

    Parameters
    ----------
    mechanism : Mechanism
    scene : Scene
        Its cue is the mechanism's, guided.
    settings : Settings
    on_state, on_command, on_strike, on_result : callable
        Told of every new state (`state` and `reason` are set by then), of every command as it is
        first given, of every strike as it is measured, and of the end of every order.

    """

    def __init__(
        self,
        mechanism: Mechanism,
        scene: Scene,
        settings: Settings,
        *,
        on_state: Callable[[], None] = lambda: None,
        on_command: Callable[[Command], None] = lambda _: None,
        on_strike: Callable[[Strike], None] = lambda _: None,
        on_result: Callable[[Result], None] = lambda _: None,
    ) -> None:
        self.state = State.DISARMED
        self.reason = 'started'
        self.estop = Input('estop', settings.estop_timeout, safe=False)
        self.interlock = Input('interlock', settings.interlock_timeout, safe=True)
        self.joints = Heartbeat('joint_states', settings.joints_timeout)
        self.clock = ClockWatch('ROS clock', settings.longest_pause)
        self.rivals = ''
        self.command: Command | None = None
        self.mechanism = mechanism
        self._scene, self._settings = scene, settings
        self._tell_state, self._tell_command = on_state, on_command
        self._tell_strike, self._tell_result = on_strike, on_result
        self._book = OrderBook(settings.order_longest)
        self._balls: Balls | None = None
        self.position = self._velocity = np.full(len(JOINTS), math.nan)
        self._ran = math.inf  # at the last tick
        self._job: Job | None = None
        self._begin = 0.0  # of the path being followed
        self._number = 0  # of the last command
        ranges = [axis.most - axis.least for axis in mechanism.axes]
        self._near = settings.aim_tolerance * np.array(ranges)

    @property
    def knows_table(self) -> bool:
        """Whether anybody has said where the balls lie."""
        return self._balls is not None

    @property
    def shot_id(self) -> str:
        """The shot that is being executed; '' if there is none."""
        return self._job.shot.plan.shot_id if self._job else ''

    def measured_elevation(self, now: float) -> tuple[float, float] | None:
        """Elevation of the cue [rad] and its rate [rad/s]; None if nothing is known of it."""
        if self.unfit(now):
            return None
        elevation = self.mechanism.triangle.elevation(float(self.position[INCLINE]))
        lever = self.mechanism.triangle.lever(elevation)
        return elevation, float(self._velocity[INCLINE]) / lever

    # --- what it hears --------------------------------------------------------------------------

    def hear_estop(self, pressed: bool, written: float, now: float) -> None:
        """Hear the emergency stop; pressed stops everything at once, however old the message."""
        self._notice_pause(now)
        self.estop.hear_value(pressed, written, now)
        if pressed and self.state is not State.ESTOP:
            self._event(Event.ESTOP, now, 'estop: pressed', Outcome.ESTOP)

    def hear_interlock(self, safe: bool, written: float, now: float) -> None:
        """Hear the interlock; opened, it stops all motion at once."""
        self._notice_pause(now)
        self.interlock.hear_value(safe, written, now)
        self._watch_interlock(now)

    def hear_joints(self, position: Array, velocity: Array, written: float, now: float) -> None:
        """Hear where the joints (6,) are [m, rad] and how fast [per s]."""
        self._notice_pause(now)
        if not self.joints.hear(written, now):
            return
        self.position, self._velocity = position, velocity
        if self.state is State.FIRING and self._job and np.isfinite(position).all():
            watch = self._job.watch
            if watch.see(position, velocity) and watch.strike:
                self._tell_strike(watch.strike)
            self._watch_brake(now)

    def hear_clock(self, time: float, now: float) -> None:
        """Hear the clock that orders are dated by [s]; if it fails, no stroke begins."""
        self.clock.see(time, now)

    def hear_rivals(self, names: Sequence[str], now: float) -> None:
        """Hear which other nodes command the mechanism; one is a fault, whatever the state."""
        self.rivals = f'another node commands the mechanism: {", ".join(names)}' if names else ''
        if names and self.state is not State.FAULT:
            self.fail(now, self.rivals)

    def hear_table(self, balls: Mapping[str, tuple[float, float]]) -> None:
        """Hear where the balls lie [m]."""
        self._balls = balls

    # --- what it is asked for -------------------------------------------------------------------

    def execute(self, order: Order, now: float) -> None:
        """
        Begin to execute an order; `on_result` tells how it ends.

        Raises
        ------
        RefusedError
            If it is refused; nothing has been done then.

        """
        self._notice_pause(now)
        if self._job:
            raise RefusedError(
                Outcome.BUSY, f'shot {self._job.shot.plan.shot_id!r} is being executed'
            )
        decision = self._decide(Event.AIM, now, order_valid=True)
        if not decision.accepted:
            raise RefusedError(Outcome.NOT_READY, decision.reason)
        self._book.enter(order)
        if self._balls is None:
            raise RefusedError(
                Outcome.TABLE_UNKNOWN, 'table_state: nobody has said where the balls lie'
            )
        complaint = moved(order.plan.balls, self._balls, self._settings.table_tolerance)
        if complaint:
            raise RefusedError(Outcome.TABLE_DIFFERS, complaint)
        shot = prepare(self.mechanism, self._scene, order.plan)
        self._job = Job(
            shot,
            now + order.remaining,
            StrokeWatch(self.mechanism, shot.profile, order.plan.shot_id),
        )
        self._event(Event.AIM, now, f'shot {order.plan.shot_id!r}')
        self._follow(aim_path(self.mechanism, self.position, shot.aimed), now)

    def arm(self, now: float) -> Decision:
        """Allow the shot that is aimed; it is fired once everything has settled."""
        self._notice_pause(now)
        decision = self._event(Event.ARM, now, 'armed')
        if decision.accepted and self._job:
            self._job.armed_until = now + self._settings.arm_timeout
            self._job.fire_at = now + self._settings.settle_time
        return decision

    def disarm(self, now: float, reason: str, outcome: Outcome = Outcome.DISARMED) -> Decision:
        """Stop whatever is going on, unless a latch has done so already."""
        return self._event(Event.DISARM, now, reason, outcome)

    def clear(self, now: float) -> Decision:
        """Leave ESTOP or FAULT, if what led there is over."""
        self._notice_pause(now)
        return self._event(Event.CLEAR, now, 'cleared')

    def fail(self, now: float, reason: str) -> None:
        """Stop, and latch, because something is wrong."""
        self._event(Event.FAIL, now, reason, Outcome.FAULT)

    # --- what it does by itself -----------------------------------------------------------------

    def tick(self, now: float) -> None:
        """Look for silence and progress; to be called at a steady rate."""
        self._notice_pause(now)
        self._ran = now
        if self.state in MOVING:
            if complaint := self.estop.complaint(now):
                self._event(Event.ESTOP, now, complaint, Outcome.ESTOP)
            self._watch_interlock(now)
        if self.state in MOVING and (complaint := self.unfit(now)):
            self.fail(now, complaint)
        if self.state in BEFORE_STROKE and (complaint := self.clock.complaint(now)):
            self._event(Event.INTERRUPTED, now, complaint, Outcome.DISARMED)
        if self._job:
            {
                State.AIMING: self._aim,
                State.AIMED: self._wait,
                State.ARMED: self._fire,
                State.FIRING: self._brake,
                State.RETRACTING: self._retract,
            }[self.state](now, self._job)

    def _notice_pause(self, now: float) -> None:
        """
        Trust nothing that was heard before, if the controller did not run for too long.

        Messages and requests that waited meanwhile come in afterwards as if they were new. So an
        input is fresh again only if a message was written some time after the pause. Until then
        requests are refused.
        """
        pause = now - self._ran
        if pause <= self._settings.longest_pause:
            return
        self._ran = now
        for each in (self.estop, self.interlock, self.joints):
            each.forget(now + RECOVERY)
        outcome = Outcome.DISARMED if self.state in BEFORE_STROKE else Outcome.FAULT
        self._event(Event.INTERRUPTED, now, f'this program did not run for {pause:.3g} s', outcome)

    def _aim(self, now: float, job: Job) -> None:
        off = np.abs(self.position - job.shot.aimed) / self._near
        if self._give_up(now, job):
            return
        late = self._late(now)
        if late >= 0.0 and off.max() <= 1.0:
            self._event(Event.REACH, now, 'waits to be armed')
        elif late > self._settings.late:
            self.fail(now, self._stuck(int(off.argmax()), job.shot.aimed))

    def _wait(self, now: float, job: Job) -> None:
        self._give_up(now, job)

    def _fire(self, now: float, job: Job) -> None:
        if self._give_up(now, job):
            return
        if now > job.armed_until:
            self._event(
                Event.EXPIRE,
                now,
                (f'armed for more than {self._settings.arm_timeout:g} s without firing'),
                Outcome.ARM_TIMEOUT,
            )
            return
        settled = (np.abs(self.position - job.shot.aimed) <= self._near).all()
        if now >= job.fire_at and settled and self._event(Event.FIRE, now, 'strikes').accepted:
            self._follow(job.shot.stroke.path, now)

    def _brake(self, now: float, job: Job) -> None:
        late = now - self._begin - job.shot.stroke.stop
        if late < 0.0:
            return
        if job.watch.strike and self._velocity[STROKE] <= 0.01:
            self._event(Event.BRAKED, now, 'draws back')
        elif late > self._settings.late:
            self.fail(now, 'stroke: the cue has not come to the ball, and stopped, in time')

    def _retract(self, now: float, job: Job) -> None:
        home = job.shot.stroke.path.positions[-1]
        off = np.abs(self.position - home) / self._near
        late = self._late(now)
        if late >= 0.0 and off.max() <= 1.0:
            self._event(Event.HOME, now, 'done')
        elif late > self._settings.late:
            self.fail(now, self._stuck(int(off.argmax()), home))

    def _watch_interlock(self, now: float) -> None:
        if self.state in MOVING and (complaint := self.interlock.complaint(now)):
            outcome = (
                Outcome.FAULT
                if self.state in (State.FIRING, State.RETRACTING)
                else Outcome.DISARMED
            )
            self._event(Event.INTERLOCK_LOST, now, complaint, outcome)

    def _watch_brake(self, now: float) -> None:
        assert self._job
        profile = self._job.shot.profile
        beyond = float(self.position[STROKE]) - max(profile.stop_at, profile.leave_at)
        if beyond > self._settings.brake_tolerance:
            self.fail(
                now,
                f'stroke: the cue is {1e3 * beyond:.3g} mm beyond where it should have '
                'stopped: the brake is late, or there was no ball',
            )

    def _give_up(self, now: float, job: Job) -> bool:
        """Drop an order that has expired, or whose table has changed."""
        if now > job.expires:
            self._event(Event.EXPIRE, now, 'the order has expired', Outcome.EXPIRED)
            return True
        complaint = self._moved(job)
        if complaint:
            self._event(Event.EXPIRE, now, complaint, Outcome.TABLE_MOVED)
        return bool(complaint)

    # --- how it decides -------------------------------------------------------------------------

    def _event(
        self, event: Event, now: float, reason: str, outcome: Outcome = Outcome.OK
    ) -> Decision:
        """Go where the table says; what ends a shot stops the mechanism and ends the order."""
        decision = self._decide(event, now)
        if not decision.accepted:
            return decision
        self.state, self.reason = decision.state, reason
        if self.state not in MOVING:
            self._number += 1
            stop = Command(self._number, None)
            self.command = None if self.state is State.DISARMED else stop
            self._tell_command(stop)
        self._tell_state()
        if self._job and self.state not in MOVING:
            job, self._job = self._job, None
            self._tell_result(Result(outcome, reason, job.watch.strike))
        return decision

    def _decide(self, event: Event, now: float, order_valid: bool = False) -> Decision:
        job = self._job
        complaints = {
            Condition.ESTOP_FRESH: self.estop.complaint(now),
            Condition.INTERLOCK_FRESH: self.interlock.complaint(now),
            Condition.MECHANISM_FIT: self.unfit(now),
            Condition.ALONE: self.rivals,
            Condition.CLOCK_RUNS: self.clock.complaint(now),
            Condition.ARMED_LATELY: '' if job and now <= job.armed_until else 'not armed',
            Condition.ORDER_VALID: ''
            if order_valid
            else 'no order'
            if job is None
            else 'the order has expired'
            if now > job.expires
            else self._moved(job),
        }
        decision = decide(
            self.state, event, {name for name, complaint in complaints.items() if not complaint}
        )
        why = '; '.join(complaints[name] for name in decision.missing)
        if not why:
            return decision
        return replace(decision, reason=f'{decision.reason} ({why})')

    def _moved(self, job: Job) -> str:
        return moved(job.shot.plan.balls, self._balls or {}, self._settings.table_tolerance)

    def unfit(self, now: float) -> str:
        """Why the mechanism is not to be trusted; '' if it is."""
        if stale := self.joints.stale(now):
            return stale
        for name, position, velocity in zip(JOINTS, self.position, self._velocity, strict=True):
            if not (math.isfinite(position) and math.isfinite(velocity)):
                return f'joint_states: {name} is at {position}, at a speed of {velocity}'
        least, most = self.mechanism.triangle.sides
        length = float(self.position[INCLINE])
        if not least < length < most:
            return (
                f'joint_states: incline is at {length:.4g} m, which is not between {least:g} '
                f'and {most:g} m'
            )
        return ''

    def _late(self, now: float) -> float:
        """For how long the path that is followed has been over [s]; below 0 if it is not."""
        assert self.command
        assert self.command.path
        return now - self._begin - self.command.path.duration

    def _stuck(self, joint: int, target: Array) -> str:
        off = float(self.position[joint] - target[joint])
        return (
            f'{JOINTS[joint]}: {off:.3g} {UNITS[joint]} from where it should have been '
            f'{self._settings.late:g} s ago'
        )

    def _follow(self, path: Path, now: float) -> None:
        self._number += 1
        self._begin = now
        self.command = Command(self._number, path)
        self._tell_command(self.command)
