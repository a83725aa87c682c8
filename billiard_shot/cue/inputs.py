"""
Data of the controller: settings, commands, results and the goal being executed; and its inputs.

The inputs are clocks, joints, safety inputs, goals, and the latched state.
"""

from collections.abc import Container, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
import math
import os
from pathlib import Path
import time
from typing import Any

import numpy as np

from billiard_shot.cue.joint_trajectory import JointTrajectory, StrokeProfile
from billiard_shot.cue.mechanism import STROKE
from billiard_shot.cue.model import forward_kinematics, TipPose
from billiard_shot.cue.plan import GoalOutcome, PreparedShot, RefusedError
from billiard_shot.cue.safety import LATCHED_STATES, SafetyState
from billiard_shot.perception.sightings import Heartbeat, TableSettings
from billiard_shot.records import Array
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


MAX_CORRECTION = 0.01
"""Largest step back that counts as a correction of a clock that is being synchronised [s]."""

MAX_LEAD = 1.0
"""
Largest advance of the clock beyond that of the steady clock in one reading [s].

A simulator that runs ten times faster than real time, and publishes its time ten times a second,
stays below it.
"""

CLOCK_RECOVERY = 2.0
"""Time after a jump before the clock is trusted again [s]."""


def steady_time() -> float:
    """Read a steady clock [s]; on Linux it goes on while the machine is suspended."""
    try:
        return time.clock_gettime(time.CLOCK_BOOTTIME)
    except AttributeError:
        return time.monotonic()


@dataclass(slots=True)
class ClockWatch:
    """Compares a clock with a steady clock: it must advance, and must not jump."""

    name: str
    timeout: float  # longest time for which the clock may stand still [s]
    time: float = math.nan  # last reading of the clock
    _advanced: float = -math.inf  # steady time at which the clock last advanced
    _jump: float = 0.0  # size of the last jump; below 0: back
    _jumped: float = -math.inf  # steady time of the last jump

    def update(self, time: float, now: float) -> None:
        """Take a reading of the clock [s] at the steady time `now` [s]."""
        step = time - self.time
        lead = step - (now - self._advanced)
        if step < -MAX_CORRECTION or (lead > MAX_LEAD and self.time != 0.0):
            self._jump, self._jumped = step, now
        if step != 0.0:
            self._advanced = now
        self.time = time

    def problem(self, now: float) -> str:
        """Return why the clock is not to be trusted; '' if it is, or if it was never read."""
        if self.time == 0.0:
            return f'{self.name}: has not started: no message received on /clock (use_sim_time)'
        if now - self._jumped <= CLOCK_RECOVERY:
            way = 'back' if self._jump < 0.0 else 'ahead'
            return f'{self.name}: jumped {way} by {abs(self._jump):.3g} s'
        if math.isfinite(self.time) and now - self._advanced > self.timeout:
            return f'{self.name}: has stood still for {now - self._advanced:.3g} s'
        return ''


class JointFeedback:
    """
    Collects messages until every joint has been measured again.

    Parameters
    ----------
    names : sequence of str
        Names of the joints in messages, in the order of `mechanism.JOINTS`.

    """

    def __init__(self, names: Sequence[str]) -> None:
        self._names = tuple(names)
        count = len(self._names)
        self._position, self._velocity = np.full(count, math.nan), np.full(count, math.nan)
        self._open = set(range(count))  # joints that are still missing

    @property
    def missing(self) -> str:
        """Names of the joints that have not been measured since the last complete set."""
        return ', '.join(self._names[i] for i in sorted(self._open))

    def update(
        self, names: Sequence[str], positions: Sequence[float], velocities: Sequence[float]
    ) -> tuple[Array, Array] | None:
        """
        Take a message; return positions and velocities (6,) once all joints were measured again.

        A missing velocity is NaN, as joint_state_broadcaster of ros2_control sends it. It is not
        computed from positions: at 100 Hz, stamps that are 0.2 ms off give a speed at the contact
        that is 3 % off.

        Parameters
        ----------
        names : sequence of str
            Joints of the message, in any order; other joints are ignored.
        positions, velocities : sequence of float
            As long as `names`, or empty [m, rad; per s].

        """
        if len(velocities) == 0:
            velocities = (math.nan,) * len(positions)
        for name, position, velocity in zip(names, positions, velocities, strict=False):
            if name in self._names:
                i = self._names.index(name)
                self._position[i], self._velocity[i] = position, velocity
                self._open.discard(i)
        if self._open:
            return None
        self._open = set(range(len(self._names)))
        return self._position.copy(), self._velocity.copy()


@dataclass(slots=True)
class HeartbeatInput:
    """
    Boolean input that every one of its publishers must repeat, and that all must call safe.

    A publisher that exists but has said nothing yet may be about to say that it is not safe. So it
    counts as silent if no message of it arrives within `timeout`.
    """

    name: str
    timeout: float  # longest allowed age of the last message of each publisher [s]
    safe: bool  # the value that allows motion
    _publishers: dict[Hashable, Heartbeat] = field(default_factory=dict)
    # Publishers that have said nothing yet: since when they are known, and their node.
    _unheard: dict[Hashable, tuple[float, str]] = field(default_factory=dict)
    _valid_from: float = -math.inf

    def record(self, value: bool, written: float, now: float, publisher: Hashable = None) -> None:
        """Record a message of a publisher; if it is not safe, even an ignored one counts."""
        last = self._publishers.get(publisher)
        if last is None:
            last = Heartbeat(self.name, self.timeout, _valid_from=self._valid_from)
            self._publishers[publisher] = last
            self._unheard.pop(publisher, None)
        if last.record(written, now) or value is not self.safe:
            last.value = value

    def keep(self, publishers: Mapping[Any, str], now: float) -> None:
        """
        Take the publishers that exist now, with the names of their nodes; forget all others.

        A publisher without an id stays. If there is one, the middleware gives no ids, and it is
        not known which publishers have been heard.
        """
        self._publishers = {
            name: each for name, each in self._publishers.items() if not name or name in publishers
        }
        self._unheard = {
            name: (self._unheard.get(name, (now,))[0], node)
            for name, node in publishers.items()
            if name not in self._publishers and all(self._publishers)
        }

    def forget(self, until: float) -> None:
        """Treat all messages written before the time `until` as not fresh."""
        self._valid_from = until
        for each in self._publishers.values():
            each.forget(until)

    def set_timeout(self, timeout: float) -> None:
        """Set the longest allowed age of messages [s]."""
        self.timeout = timeout
        for each in self._publishers.values():
            each.timeout = timeout

    def problem(self, now: float) -> str:
        """Return why the input does not allow motion; '' if it does."""
        if not self._publishers:
            return Heartbeat(self.name, self.timeout, _valid_from=self._valid_from).stale(now)
        problems = [
            each.stale(now)
            or ('' if each.value is self.safe else f'{self.name}: is {str(each.value).lower()}')
            for each in self._publishers.values()
        ]
        problems += [
            f'{self.name}: no message received from {node}'
            for since, node in self._unheard.values()
            if now - since > self.timeout
        ]
        found = [each for each in problems if each]
        if not found:
            return ''
        count = len(self._publishers) + len(self._unheard)
        several = f' (one of {count} publishers)' if count > 1 else ''
        return found[0] + several


def check_goal(
    shot_id: str, remaining: float, played: Container[str], max_validity: float
) -> None:
    """
    Check that a shot is new, and that its goal is valid for a time [s] up to `max_validity`.

    Raises
    ------
    RefusedError
        ALREADY_PLAYED, ALREADY_EXPIRED or INVALID_PLAN, with the reason.

    """
    if shot_id in played:
        raise RefusedError(
            GoalOutcome.ALREADY_PLAYED,
            f'shot_id must be new, got {shot_id!r}: the cue has been aimed for it before',
        )
    if not remaining > 0.0:
        raise RefusedError(
            GoalOutcome.ALREADY_EXPIRED,
            f'expiry must be ahead of now, got {-remaining:.3g} s ago',
        )
    if remaining > max_validity:
        raise RefusedError(
            GoalOutcome.INVALID_PLAN,
            f'expiry must be at most {max_validity:g} s ahead, got {remaining:.6g} s',
        )


def check_stamp(stamp: float, started: float, latest: float) -> None:
    """Refuse a plan without a stamp (0), from before this program `started`, or after `latest`."""
    if not started <= stamp <= latest:  # a program that is started again has forgotten its shots
        raise RefusedError(
            GoalOutcome.INVALID_PLAN if stamp > latest else GoalOutcome.ALREADY_EXPIRED,
            f'plan.header.stamp must be from {started:.3f}, the start of the driver, to '
            f'{latest:.3f}, got {stamp:.3f} (s)',
        )


UNKNOWN = SafetyState.FAULT, 'state unknown: clear_fault'
"""State and reason if the file is damaged."""


def read_latched(path: Path) -> tuple[SafetyState, str] | None:
    """
    Read the latched state and its reason; None if there is no file.

    Raises
    ------
    OSError
        If the file cannot be read, or if it could not be written again.

    """
    _write_beside(path, '').unlink()
    if not path.exists():
        return None
    name, _, reason = path.read_text('utf-8', 'replace').removesuffix('\n').partition(' ')
    found = [state for state in LATCHED_STATES if state.name == name]
    return (found[0], reason) if found and reason else UNKNOWN


def write_latched(path: Path, state: SafetyState, reason: str) -> None:
    """
    Write a latched state, such that it survives a loss of power; remove the file if it is not one.

    Raises
    ------
    OSError
        If that is not possible.

    """
    if state in LATCHED_STATES:
        os.replace(_write_beside(path, f'{state.name} {reason}\n'), path)
    elif path.exists():
        path.unlink()
    else:
        return
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def _write_beside(path: Path, text: str) -> Path:
    """Write a file in the folder of another one, down to the disk, and return its path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f'{path.name}.new')
    with beside.open('w', encoding='utf-8', errors='replace') as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    return beside
