"""Inputs of the controller that must be repeated: their values, and whether they are fresh."""

from dataclasses import dataclass
import math


@dataclass(slots=True)
class Heartbeat:
    """
    Freshness of an input that must be repeated; times are those of a steady clock [s].

    An input is fresh for `timeout` after its last message was *written*. The time at which a
    message is received proves nothing: a message may have waited in a queue.

    Parameters
    ----------
    name : str
    timeout : float
        Longest allowed age of the last message [s].

    """

    name: str
    timeout: float
    written: float = -math.inf
    _valid_from: float = -math.inf
    _ahead: float = 0.0

    def hear(self, written: float, now: float) -> bool:
        """
        Record a message; return whether it replaces the one before.

        It does not if it is older than that one. It does not either if it was written more than
        `timeout` in the future, because then the clock of its publisher is wrong.
        """
        self._ahead = max(written - now, 0.0)
        if self._ahead > self.timeout or written < self.written:
            return False
        self.written = min(written, now)
        return True

    def forget(self, until: float) -> None:
        """Treat everything that is written before the time `until` as not fresh."""
        self._valid_from = until

    def stale(self, now: float) -> str:
        """Return why the input is not fresh; '' if it is."""
        if self._ahead > self.timeout:
            return (
                f'{self.name}: written {self._ahead:.3g} s in the future: its clock and the '
                'clock of this machine differ'
            )
        if self.written == -math.inf:
            return f'{self.name}: never heard'
        if now < self._valid_from:
            left = self._valid_from - now
            return (
                f'{self.name}: not trusted for another {left:.2g} s, because this program paused'
            )
        if self.written < self._valid_from:
            return f'{self.name}: not heard again since this program paused'
        age = now - self.written
        if age > self.timeout:
            return f'{self.name}: silent for {age:.3g} s, more than {self.timeout:g} s'
        return ''


@dataclass(slots=True)
class Input(Heartbeat):
    """
    Yes-or-no input that must be repeated.

    Parameters
    ----------
    safe : bool
        The value that allows motion.

    """

    safe: bool = True
    value: bool | None = None

    def hear_value(self, value: bool, written: float, now: float) -> None:
        """Record a value, unless a later one is known."""
        if self.hear(written, now):
            self.value = value

    def complaint(self, now: float) -> str:
        """Return why the input does not allow motion; '' if it does."""
        if stale := self.stale(now):
            return stale
        return '' if self.value is self.safe else f'{self.name}: is {str(self.value).lower()}'
