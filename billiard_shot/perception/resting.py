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

    def restless(self, balls: Balls, now: float) -> str:
        """Say why the balls do not rest at the time `now` [s]; '' if all rest."""
        moving = [name for name in balls if not _rests(balls[name], self._last.get(name))]
        if moving or balls.keys() != self._last.keys():
            self._last, self._since = balls, now
        elif now - self._since > REST_TIME:
            return ''
        if not moving:
            return f'the balls have not rested for {REST_TIME:g} s'
        name = moving[0]
        return f'ball {name!r} {"moves on" if balls[name].is_seen else "is not seen"}'


def _rests(ball: Sighting, last: Sighting | None) -> bool:
    """Whether a ball is seen at rest where it was before."""
    return (
        ball.is_seen
        and not ball.is_moving
        and last is not None
        and math.dist(ball.position, last.position) <= REST_DISTANCE
    )
