"""
Sightings of balls: where a ball was detected, how surely; does it rest, where can it lie.

`TableWatch` says whether the balls that a camera last saw are known well enough for a shot.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, product
import math
from typing import ClassVar

import numpy as np

from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.fields import CheckedRecord, number
from billiard_shot.scene.placement import no_place, nose_standoff, Place

SURE_SIGMAS = 4.0
"""
Number of standard deviations beyond which a distance between two sightings is not noise.

Two sightings of one place differ by more with a probability of exp(-8), about 1 in 3000 (Rayleigh
distribution), and the tolerance comes on top.
"""


@dataclass(frozen=True, slots=True)
class Sighting:
    """One ball, as it was last detected."""

    position: tuple[float, float]  # centre, x and y in the frame `table`, m
    # xx, xy, yy, m^2, without errors that all pictures have in common; zeros: exact
    covariance: tuple[float, float, float] = (0.0, 0.0, 0.0)
    is_seen: bool = True  # at present; if it is not seen, it may be anywhere
    is_moving: bool = False
    time: float = 0.0  # of the last detection, on the clock of the messages, s; 0: not known
    systematic_error: float = 0.0  # of x and y, in all pictures: standard deviation, m

    @property
    def deviation(self) -> float:
        """
        Standard deviation of a coordinate from where the ball is [m]; 0 if the place is exact.

        It is the root of the mean of both variances, with the systematic error.
        """
        xx, _, yy = self.covariance
        return math.sqrt(0.5 * (xx + yy) + self.systematic_error**2)


Balls = Mapping[str, Sighting]


def largest_deviation(balls: Balls) -> float:
    """Largest standard deviation of a coordinate of a ball [m]; 0 if all positions are exact."""
    return max((each.deviation for each in balls.values()), default=0.0)


def moved(planned: Balls, seen: Balls, tolerance: float, may_be_hidden: bool = False) -> str:
    """
    Return which ball does not lie at its planned place; '' if all do.

    A ball lies elsewhere if its distance from the planned place is more than `tolerance` [m] plus
    `SURE_SIGMAS` standard deviations of that distance. The errors of both positions are
    independent; systematic errors are the same in both, and do not count. A ball that is not seen
    lies where it was last seen if it `may_be_hidden`.
    """
    for name in sorted(planned.keys() | seen.keys()):
        if name not in seen:
            return f'ball {name!r} of the plan is not on the table'
        if name not in planned:
            return f'ball {name!r} is on the table, but not in the plan'
        if not (seen[name].is_seen or may_be_hidden):
            return f'ball {name!r} is not seen'
        if seen[name].is_moving:
            return f'ball {name!r} moves'
        distance, deviation = distance_between(planned[name], seen[name])
        allowed = tolerance + SURE_SIGMAS * deviation
        if not distance <= allowed:
            return (
                f'ball {name!r} lies {1e3 * distance:.3g} mm from its planned place; must be at '
                f'most {1e3 * allowed:.3g} mm'
            )
    return ''


def uncertain(planned: Balls, seen: Balls, limit: float) -> str:
    """
    Return which ball has an uncertain distance from its planned place; '' if none has.

    The distance is certain if `SURE_SIGMAS` of its standard deviations are at most `limit` [m] in
    every direction, because a distance of zero has none.
    """
    for name in sorted(planned.keys() & seen.keys()):
        covariances = planned[name].covariance, seen[name].covariance
        xx, xy, yy = (a + b for a, b in zip(*covariances, strict=True))
        largest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)  # eigenvalue
        if not (error := SURE_SIGMAS * math.sqrt(max(largest, 0.0))) <= limit:
            return (
                f'ball {name!r}: {SURE_SIGMAS:g} standard deviations of its distance from the '
                f'planned place must be at most {1e3 * limit:g} mm, got {1e3 * error:.3g} mm'
            )
    return ''


def distance_between(one: Sighting, other: Sighting) -> tuple[float, float]:
    """Distance of two sightings [m], and the standard deviation of the distance [m]."""
    dx, dy = (b - a for a, b in zip(one.position, other.position, strict=True))
    distance = math.hypot(dx, dy)
    xx, xy, yy = (a + b for a, b in zip(one.covariance, other.covariance, strict=True))
    if not distance > 0.0:
        return distance, 0.0
    u, v = dx / distance, dy / distance
    variance = u * u * xx + 2.0 * u * v * xy + v * v * yy
    return distance, math.sqrt(max(variance, 0.0))


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


GAP_AFTER_MOVE = 1e-6
"""Gap between balls, and to a cushion, after they were moved [m]."""

NEIGHBOUR_SIGMAS = 3.0 * SURE_SIGMAS
"""Balls farther apart, and from a cushion, than so many standard deviations do not meet."""

MAX_ROUNDS = 1000
"""Largest number of rounds over all limits: a rack takes up to 40."""

Limit = tuple[Array, float]
"""Coefficients (balls, 2) of the moves of all balls, and the least sum of the products [m]."""


def positions_of(balls: Balls, scene: Scene) -> dict[str, Place]:
    """
    Positions (x, y) [m] of balls on the table of a scene, by name.

    Balls that overlap each other or a cushion by no more than `SURE_SIGMAS` standard deviations
    are moved until they touch. The sum of the squares of all moves, in standard deviations of each
    ball, is the smallest. Larger overlaps are kept; the caller must reject them.
    """
    seen = {name: ball.position for name, ball in balls.items()}
    places = np.array(list(seen.values())).reshape(-1, 2)
    deviations = np.array([ball.deviation for ball in balls.values()])
    limits = [*_apart(places, deviations, scene), *_in_bed(places, deviations, scene)]
    if not any(least > 0.0 for _, least in limits):
        return seen
    rows = np.array([(row * deviations[:, np.newaxis]).ravel() for row, _ in limits])
    least = np.array([least for _, least in limits])
    products = rows @ rows.T
    # Hildreth's method ("A quadratic programming procedure", 1957): the multipliers one by one.
    multipliers = np.zeros(len(limits))
    for _ in range(MAX_ROUNDS):
        for i, row in enumerate(products):
            step = (least[i] - row @ multipliers) / row[i]
            multipliers[i] = max(0.0, multipliers[i] + step)
        if (least - products @ multipliers).max() < 0.5 * GAP_AFTER_MOVE:
            moves = (rows.T @ multipliers).reshape(-1, 2)
            moved = (places + deviations[:, np.newaxis] * moves).tolist()
            return {name: (x, y) for name, (x, y) in zip(seen, moved, strict=True)}
    return seen  # there is no place for all


def _apart(places: Array, deviations: Array, scene: Scene) -> Iterator[Limit]:
    """Limits that keep balls apart which may touch, along the lines on which they were seen."""
    for i, k in combinations(range(len(places)), 2):
        way, deviation = places[k] - places[i], np.hypot(deviations[i], deviations[k])
        distance = np.hypot(*way)
        overlap = 2.0 * scene.ball.radius - distance
        if distance > 0.0 and _may_touch(overlap, deviation):
            row = np.zeros_like(places)
            row[k], row[i] = way / distance, -way / distance
            yield row, overlap + GAP_AFTER_MOVE


def _in_bed(places: Array, deviations: Array, scene: Scene) -> Iterator[Limit]:
    """Limits that keep balls out of cushions which they may touch; not in mouths of pockets."""
    if scene.table is None:
        return
    standoff = nose_standoff(
        2.0 * scene.ball.radius * scene.table.cushion.height, scene.ball.radius
    )
    half = 0.5 * scene.table.length - standoff, 0.5 * scene.table.width - standoff
    for i, axis, sign in product(range(len(places)), (0, 1), (-1.0, 1.0)):
        x, y = places[i].tolist()
        overlap = sign * (x, y)[axis] - half[axis]
        is_in_mouth = overlap > 0.0 and not no_place(scene.table, x, y, scene.ball.radius)
        if _may_touch(overlap, deviations[i]) and not is_in_mouth:
            row = np.zeros_like(places)
            row[i, axis] = -sign
            yield row, overlap + GAP_AFTER_MOVE


def _may_touch(overlap: float, deviation: float) -> bool:
    """Whether an overlap with a standard deviation [m] may be 0; negative overlaps are gaps."""
    return -NEIGHBOUR_SIGMAS * deviation < overlap <= SURE_SIGMAS * deviation


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
class TableSettings(CheckedRecord):
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
