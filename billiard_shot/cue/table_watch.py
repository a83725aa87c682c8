"""
The balls that a camera last saw, and whether they are still known.

Each ball has the time of its last detection, and a message has the time at which it was written.

- *Before a shot is aimed*, every ball must have been detected within `table_timeout`.
- *While a shot is aimed*, the cue and the carriage hide balls. A ball may be unseen for
  `unseen_timeout`, and counts as lying where it was seen last. This is safe, because a ball at
  rest does not move by itself, the interlock keeps people away, and the time is limited.
  Messages must still arrive within `table_timeout`: a camera that has ended is noticed at once.
"""

from collections.abc import Mapping
from dataclasses import replace
import math

from billiard_shot.cue.execution import Settings
from billiard_shot.cue.inputs import Heartbeat
from billiard_shot.cue.sightings import Balls, moved, Sighting


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

    def stale(self, stamp_now: float, now: float) -> str:
        """Return why the balls are not known well enough to aim a shot; '' if they are."""
        return self._stale(stamp_now, now, self._settings.table_timeout)

    def stale_while_aimed(self, stamp_now: float, now: float) -> str:
        """Return why the balls are no longer known for an aimed shot; '' if they are."""
        return self._stale(stamp_now, now, self._settings.unseen_timeout)

    def moved(self, planned: Balls) -> str:
        """Return which ball does not lie, and is not seen, at its planned place; '' if all do."""
        return moved(planned, self._balls, self._settings.table_tolerance)

    def moved_while_aimed(self, planned: Balls) -> str:
        """Return which ball did not lie at its planned place when it was last seen."""
        seen: Mapping[str, Sighting] = {
            name: replace(ball, is_seen=True) for name, ball in self._balls.items()
        }
        return moved(planned, seen, self._settings.table_tolerance)

    def _stale(self, stamp_now: float, now: float, limit: float) -> str:
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
