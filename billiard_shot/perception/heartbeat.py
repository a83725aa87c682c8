"""Freshness of an input that must be repeated."""

from dataclasses import dataclass
import math


@dataclass(slots=True)
class Heartbeat:
    """
    Freshness of an input that must be repeated; times are those of a steady clock [s].

    An input is fresh for `timeout` after its last message was *written*. The time of reception is
    not used, because a message may have waited in a queue.
    """

    name: str
    timeout: float  # longest allowed age of the last message [s]
    value: bool | None = None  # of the last message, if the input has one
    news: str = 'message'  # what must be repeated, in words
    written: float = -math.inf  # time of the last message
    _valid_from: float = -math.inf
    _ahead: float = 0.0

    def record(self, written: float, now: float) -> bool:
        """
        Record a message; return False if it is ignored.

        A message is ignored if it is older than the last one. It is also ignored if it was written
        more than `timeout` in the future, because then the clock of its publisher is wrong.
        """
        self._ahead = max(written - now, 0.0)
        if self._ahead > self.timeout or written < self.written:
            return False
        self.written = min(written, now)
        return True

    def forget(self, until: float) -> None:
        """Treat all messages written before the time `until` as not fresh."""
        self._valid_from = until

    def stale(self, now: float) -> str:
        """Return why the input is not fresh; '' if it is."""
        if self._ahead > self.timeout:
            return (
                f'{self.name}: written {self._ahead:.3g} s in the future: the clocks of the '
                'publisher and of this machine differ'
            )
        if self.written == -math.inf:
            return f'{self.name}: no {self.news} received'
        if now < self._valid_from:
            left = self._valid_from - now
            return (
                f'{self.name}: not trusted for another {left:.2g} s, because this process paused'
            )
        if self.written < self._valid_from:
            return f'{self.name}: no {self.news} since this process paused'
        age = now - self.written
        if age > self.timeout:
            return f'{self.name}: no {self.news} for {age:.3g} s, limit {self.timeout:g} s'
        return ''
