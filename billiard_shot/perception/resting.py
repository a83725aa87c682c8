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
        """Say which ball does not rest at the time `now` [s], and why; '' if all rest."""
        moving = [name for name in balls if not _rests(balls[name], self._last.get(name))]
        if moving or balls.keys() != self._last.keys():
            self._last, self._since = balls, now
        elif now - self._since > REST_TIME:
            return ''
        name = moving[0] if moving else ''
        fault = 'moves on' if not name or balls[name].is_seen else 'is not seen'
        return f'ball {name!r} {fault}'


def _rests(ball: Sighting, last: Sighting | None) -> bool:
    """Whether a ball is seen at rest where it was before."""
    return (
        ball.is_seen
        and not ball.is_moving
        and last is not None
        and math.dist(ball.position, last.position) <= REST_DISTANCE
    )
