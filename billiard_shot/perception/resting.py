"""Whether all balls rest, told from sightings over time."""

import math

from billiard_shot.perception.sightings import Balls, Sighting

REST_DISTANCE = 1e-3
"""A ball that moves less than this [m] within `REST_TIME` is at rest."""

REST_TIME = 0.5
"""Time in which a ball at rest moves less than `REST_DISTANCE` [s]."""


class RestWatch:
    """Compares the balls with those before."""

    def __init__(self) -> None:
        self._last: Balls = {}
        self._since = -math.inf  # when they were last seen to move [s]

    def restless(self, balls: Balls, now: float, unseen_time: float = math.inf) -> str:
        """
        Say why the balls do not rest at the time `now` [s]; '' if all rest.

        Balls that are not seen count as resting once all others have rested for `unseen_time` [s].
        """
        moving = [name for name in balls if not _rests(balls[name], self._last.get(name))]
        if moving or balls.keys() != self._last.keys():
            self._last, self._since = balls, now
        rested = now - self._since
        unseen = [name for name in balls if not balls[name].is_seen]
        if rested > (unseen_time if unseen else REST_TIME):
            return ''
        for name in (*moving, *unseen):
            return f'ball {name!r} {"moves on" if balls[name].is_seen else "is not seen"}'
        return f'the balls have not rested for {REST_TIME:g} s'


def _rests(ball: Sighting, last: Sighting | None) -> bool:
    """Whether a ball is where it was before, or was and is not seen."""
    return (
        last is not None
        and ball.is_seen == last.is_seen
        and not (ball.is_seen and ball.is_moving)
        and math.dist(ball.position, last.position) <= REST_DISTANCE
    )
