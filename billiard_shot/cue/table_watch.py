"""
The balls that a camera last saw, and whether they are still known.

Each ball has the time of its last detection, and a message has the time at which it was written.

- *Before a shot is aimed*, every ball must have been detected within `table_timeout`.
- *While a shot is aimed*, the cue and the carriage hide balls. A ball may be unseen for
  `unseen_timeout`, and counts as lying where it was seen last. This is safe, because a ball at
  rest does not move by itself, the interlock keeps people away, and the time is limited.
  Messages must still arrive within `table_timeout`: a camera that has ended is noticed at once.
"""

import math

from billiard_shot.cue.execution import Settings
from billiard_shot.cue.inputs import Heartbeat
from billiard_shot.perception.sightings import Balls, moved


class TableWatch:
    """
    The last table state; times are those of a steady clock and, if so named, of the stamps [s].

    Parameters
    ----------
    settings : Settings

    """

    def __init__(self, settings: Settings) -> None:
        self.heartbeat = Heartbeat('table_state', settings.table_timeout)
        self._settings = settings
        self._balls: Balls = {}
        self._fault = 'table_state: no valid message received'

    def record(self, balls: Balls, written: float, stamp_now: float, now: float) -> None:
        """Take the balls of a message; `stamp_now` is the current time of the stamps."""
        self.heartbeat.record(written, now)
        self._balls, self._fault = balls, ''
        tolerance = self._settings.stamp_tolerance
        for name, ball in balls.items():
            ahead = ball.time - stamp_now
            if not ahead <= tolerance:
                self.reject(
                    f'table_state: the last detection of ball {name!r} must be at most '
                    f'{tolerance:g} s ahead of now, got {ahead:.3g} s'
                )

    def reject(self, reason: str) -> None:
        """Know the balls no longer, because a message was not valid."""
        self._balls, self._fault = {}, reason

    def moved(self, planned: Balls, *, is_aimed: bool) -> str:
        """Return which ball does not lie, or is not seen, at its planned place; '' if all do."""
        return moved(planned, self._balls, self._settings.table_tolerance, is_aimed)

    def stale(self, stamp_now: float, now: float, *, is_aimed: bool) -> str:
        """Return why the balls are not known well enough for a shot; '' if they are."""
        limit = self._settings.unseen_timeout if is_aimed else self._settings.table_timeout
        if problem := self._fault or self.heartbeat.stale(now):
            return problem
        if not math.isfinite(stamp_now):
            return 'table_state: the time is not known'
        for name, ball in self._balls.items():
            age = stamp_now - ball.time
            if age > limit:
                return (
                    f'table_state: ball {name!r} was last detected {age:.3g} s ago; must be at '
                    f'most {limit:g} s'
                )
        return ''
