"""A steady clock, and a monitor of a clock that another machine, a simulator or a bag may set."""

from dataclasses import dataclass
import math
import time

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
