"""Safety inputs of the controller, which must be repeated: their values, and who gives them."""

from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
import math
from typing import Any

from billiard_shot.perception.heartbeat import Heartbeat


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
