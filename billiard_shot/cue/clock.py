"""A steady clock, and a monitor of a clock that another machine, a simulator or a bag may set."""

from dataclasses import dataclass
import math
import time

STEP_BACK = 0.01
"""Largest step back that counts as a correction of a clock that is being synchronised [s]."""

RECOVERY = 2.0
"""Time after a jump back before the clock is trusted again [s]."""


def steady_time() -> float:
    """Read a steady clock [s]; on Linux it goes on while the machine is suspended."""
    try:
        return time.clock_gettime(time.CLOCK_BOOTTIME)
    except AttributeError:
        return time.monotonic()


@dataclass(slots=True)
class ClockWatch:
    """
    Compares a clock with a steady clock: it must advance, and must not jump back.

    Parameters
    ----------
    name : str
    timeout : float
        Longest time for which the clock may stand still [s].

    """

    name: str
    timeout: float
    _time: float = math.nan  # last reading of the clock
    _advanced: float = -math.inf  # steady time at which the clock last advanced
    _back: float = 0.0  # size of the last jump back
    _jumped: float = -math.inf  # steady time of the last jump back

    def update(self, time: float, now: float) -> None:
        """Take a reading of the clock [s] at the steady time `now` [s]."""
        if time < self._time - STEP_BACK:
            self._back, self._jumped = self._time - time, now
        if time != self._time:
            self._advanced = now
        self._time = time

    def problem(self, now: float) -> str:
        """Return why the clock is not to be trusted; '' if it is, or if it was never read."""
        if self._time == 0.0:
            return f'{self.name}: has not started: no message received on /clock (use_sim_time)'
        if now - self._jumped <= RECOVERY:
            return f'{self.name}: jumped back by {self._back:.3g} s'
        if math.isfinite(self._time) and now - self._advanced > self.timeout:
            return f'{self.name}: has stood still for {now - self._advanced:.3g} s'
        return ''
