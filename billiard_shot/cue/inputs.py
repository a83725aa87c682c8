"""Inputs of the controller that must be repeated: their values, and whether they are fresh."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
import math
from typing import Any


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
            return f'{self.name}: no message received'
        if now < self._valid_from:
            left = self._valid_from - now
            return (
                f'{self.name}: not trusted for another {left:.2g} s, because this process paused'
            )
        if self.written < self._valid_from:
            return f'{self.name}: no message since this process paused'
        age = now - self.written
        if age > self.timeout:
            return f'{self.name}: no message for {age:.3g} s, limit {self.timeout:g} s'
        return ''


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
