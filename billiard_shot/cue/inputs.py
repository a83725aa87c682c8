"""Inputs of the controller: clocks, joints, safety inputs, goals, and the latched state."""

from collections.abc import Container, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
import math
import os
from pathlib import Path
import time
from typing import Any

import numpy as np

from billiard_shot.cue.plan import GoalOutcome, RefusedError
from billiard_shot.cue.safety import LATCHED_STATES, SafetyState
from billiard_shot.perception.sightings import Heartbeat
from billiard_shot.records import Array

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
            GoalOutcome.ALREADY_EXPIRED, f'expiry must be ahead of now, got {-remaining:.3g} s ago'
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
