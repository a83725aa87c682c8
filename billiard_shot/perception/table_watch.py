"""The balls that a camera last saw, and whether they are known well enough for a shot."""

from collections.abc import Collection
from dataclasses import dataclass
import math
from typing import ClassVar

from billiard_shot.perception.sightings import Balls, moved, uncertain
from billiard_shot.scene.fields import check, number


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


EMPTY_VIEW = 2.0
"""Longest time from the last detection of any ball to the last picture [s]: a covered lens."""

PRECISION = 1.5e-3
"""Largest uncertainty of the distance of a ball from its planned place [m], see `uncertain`."""


@dataclass(frozen=True, slots=True)
class TableSettings:
    """
    Time-outs and tolerances of the table state.

    Parameters
    ----------
    table_timeout : float
        Longest time since the last picture on `table_state` and, before aiming, since the last
        detection of each ball [s].
    unseen_timeout : float
        Longest time since the last detection of a ball that the cue may hide, while a shot is
        aimed [s].
    hidden_width : float
        Largest distance from the axis of the armed cue, behind its tip, at which cue and carriage
        hide balls from the camera [m].
    stamp_tolerance : float
        Largest lead of the time of a picture, a detection or a plan ahead of the clock [s].
    table_tolerance : float
        Largest distance of a ball from its planned place [m].

    """

    READ_ONLY: ClassVar = ('table_timeout', 'unseen_timeout', 'stamp_tolerance')  # as parameters
    table_timeout: float = number('s', minimum=0.05, maximum=5.0, default=1.0)
    unseen_timeout: float = number('s', minimum=0.05, maximum=60.0, default=10.0)
    hidden_width: float = number('m', minimum=0.0, maximum=5.0, default=0.1)
    stamp_tolerance: float = number('s', minimum=0.0, maximum=1.0, default=0.1)
    table_tolerance: float = number('m', minimum=0.0, maximum=0.02, default=0.001)

    def __post_init__(self) -> None:
        check(self)


class TableWatch:
    """
    The last table state; times are those of a steady clock and, if so named, of the stamps [s].

    Parameters
    ----------
    settings : TableSettings

    """

    def __init__(self, settings: TableSettings) -> None:
        self.heartbeat = Heartbeat('table_state', settings.table_timeout, news='picture')
        self._settings = settings
        self._balls: Balls = {}
        self._picture = -math.inf  # stamp of the last picture [s]
        self._fault = 'table_state: no valid message received'

    def record(
        self, balls: Balls, picture: float, written: float, stamp_now: float, now: float
    ) -> None:
        """Take the balls of a message, and the stamps of its last picture and of now."""
        if picture != self._picture:
            self.heartbeat.record(written, now)
        self._balls, self._picture, self._fault = balls, picture, ''
        ahead = max([picture, *(ball.time for ball in balls.values())]) - stamp_now
        if not ahead <= (tolerance := self._settings.stamp_tolerance):
            most = f'at most {tolerance:g} s ahead of now'
            self.reject(f'table_state: stamps must be {most}, got {ahead:.3g} s')

    def reject(self, reason: str) -> None:
        """Know the balls no longer, because a message was not valid."""
        self._balls, self._fault = {}, reason

    def moved(self, planned: Balls, *, is_aimed: bool) -> str:
        """Return which ball does not lie, or is not seen, at its planned place; '' if all do."""
        return moved(planned, self._balls, self._settings.table_tolerance, is_aimed)

    def uncertain(self, planned: Balls) -> str:
        """Return which ball has an uncertain distance from its planned place; '' if none has."""
        return uncertain(planned, self._balls, PRECISION)

    def stale(self, stamp_now: float, now: float, hidden: Collection[str] = ()) -> str:
        """
        Return why the last picture or detections are too old for a shot; '' if they are not.

        The mechanism may hide the balls whose names are in `hidden`.
        """
        if problem := self._fault or self.heartbeat.stale(now):
            return problem
        settings, picture = self._settings, self._picture
        ages = {'picture': (stamp_now - picture, settings.table_timeout)}
        for name, ball in self._balls.items():
            limit = settings.unseen_timeout if name in hidden else settings.table_timeout
            ages[f'detection of ball {name!r}'] = stamp_now - ball.time, limit
        newest = max((ball.time for ball in self._balls.values()), default=picture)
        ages['picture that shows a ball'] = picture - newest, EMPTY_VIEW
        for event, (age, longest) in ages.items():
            if not age <= longest:
                most = f'at most {longest:g} s old'
                return f'table_state: the last {event} must be {most}, got {age:.3g} s'
        return ''
