"""Supervision of a clock that other machines set, or a simulator, or a bag that is played."""

from dataclasses import dataclass
import math

STEP_BACK = 0.01
"""Steps back of up to this are corrections of a clock that is being synchronised [s]."""

RECOVERY = 2.0
"""A clock must run for this long after a jump back before it is trusted again [s]."""


@dataclass(slots=True)
class ClockWatch:
    """
    Compares a clock with a steady one: the clock must advance, and must not jump back.

    Parameters
    ----------
    name : str
    patience : float
        Longest time for which the clock may stand still [s].

    """

    name: str
    patience: float
    _time: float = math.nan  # of the clock, when it was last read
    _advanced: float = -math.inf  # steady time at which the clock last advanced
    _back: float = 0.0  # size of the last jump back
    _jumped: float = -math.inf  # steady time of the last jump back

    def see(self, time: float, now: float) -> None:
        """Take a reading of the clock at the steady time `now` [s]."""
        if time < self._time - STEP_BACK:
            self._back, self._jumped = self._time - time, now
        if time != self._time:
            self._advanced = now
        self._time = time

    def complaint(self, now: float) -> str:
        """Return why the clock is not to be trusted; '' if it is, or was never read."""
        if self._time == 0.0:
            return f'{self.name}: has not started: nothing was heard on /clock (use_sim_time)'
        if now - self._jumped <= RECOVERY:
            return f'{self.name}: jumped back by {self._back:.3g} s'
        if math.isfinite(self._time) and now - self._advanced > self.patience:
            return f'{self.name}: has stood still for {now - self._advanced:.3g} s'
        return ''
