"""
Tracks: which ball of a picture is which one of the pictures before.

A ball is expected where its velocity takes it, and has its colour. All balls of a picture are
matched at once, with the least sum of costs (Kuhn 1955, The Hungarian method). A hidden ball keeps
its track, which goes on within a circle that grows.
"""

from dataclasses import dataclass, field
from itertools import combinations
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from billiard_shot.film.balls import SEEN, Seen
from billiard_shot.film.lens import Floats

FASTEST = 7.0
"""No ball is faster [m/s]."""

LONGEST_GUESS = 0.25
"""The velocity of a hidden ball is trusted for so long [s]."""

NEAR, TURN = 0.004, 0.35
"""Expected errors of a prediction: at rest [m], and as a part of the way since the last one."""

GATE = 0.03
"""A ball at rest is sought so far away [m]."""

COLOUR, MOST_COLOURS = 18.0, 4.0
"""Expected change of the colour of a ball [of 255]; so many expected ones are another ball."""

MOST_FAR = 30.0
"""Largest part of a cost that a distance can have."""

UNSURE = 3.0
"""Two balls may have been exchanged if that costs less more than this."""

LEAST_SEEN = 8
"""Fewer sights are no ball."""

ALIVE = 2.0
"""A spot that was seen fewer times is forgotten after so long [s]."""


@dataclass(slots=True, eq=False)
class Path:
    """
    The places where a spot was seen, picture after picture.

    Attributes
    ----------
    seen : list of records SEEN
        In the order of their times.
    colour : (3,) float array
        Mean of the last sights [of 255].
    velocity : (2,) float array
        Of the last two sights [m/s].
    name : str
        Of the ball that it is; empty: of none.

    """

    seen: list[Any] = field(default_factory=list)
    colour: Floats = field(default_factory=lambda: np.zeros(3))
    velocity: Floats = field(default_factory=lambda: np.zeros(2))
    name: str = ''

    @property
    def sights(self) -> Seen:
        """All of them as an array."""
        return np.array(self.seen, SEEN)

    def add(self, sight: Any) -> None:
        """Add a sight."""
        if self.seen:
            last = self.seen[-1]
            self.velocity = (sight['place'] - last['place']) / max(
                sight['time'] - last['time'], 1e-3
            )
        self.seen.append(sight)
        weight = max(1.0 / len(self.seen), 0.05)
        self.colour = self.colour + weight * (sight['colour'] - self.colour)


class Tracker:
    """
    Tracks balls from picture to picture.

    Attributes
    ----------
    paths : list of Path
    unsure : dict of (Path, Path) to float
        When two balls may have been exchanged first [s].

    """

    def __init__(self) -> None:
        self.paths: list[Path] = []
        self.unsure: dict[tuple[Path, Path], float] = {}

    def _alive(self, time: float) -> list[Path]:
        """Return the paths that may go on."""
        return [
            path for path in self.paths
            if len(path.seen) >= LEAST_SEEN
            or time - path.seen[-1]['time'] < ALIVE * len(path.seen) / LEAST_SEEN
        ]  # fmt: skip

    def add(self, seen: Seen, time: float) -> None:
        """Add the balls of a picture of a time [s], each of which has its own time."""
        paths = self._alive(time)
        costs = self._costs(paths, seen)
        rows, columns = linear_sum_assignment(np.minimum(costs, 1e6))
        matched = [(i, k) for i, k in zip(rows, columns, strict=True) if np.isfinite(costs[i, k])]
        for (i, k), (j, m) in combinations(matched, 2):
            if costs[i, m] + costs[j, k] - costs[i, k] - costs[j, m] < UNSURE:
                self.unsure.setdefault((paths[i], paths[j]), time)
        for i, k in matched:
            paths[i].add(seen[k])
        for k in set(range(len(seen))) - {k for _, k in matched}:
            self.paths.append(path := Path())
            path.add(seen[k])

    def forget(self, before: float) -> None:
        """Forget the sights before a time [s], and the paths without others."""
        self.paths = [path for path in self.paths if path.seen[-1]['time'] >= before]
        self.unsure.clear()
        for path in self.paths:
            path.seen = [sight for sight in path.seen if sight['time'] >= before]

    def _costs(self, paths: list[Path], seen: Seen) -> Floats:
        """Return the costs (paths, balls) of matches; infinite ones cannot be."""
        if not paths or not len(seen):
            return np.empty((len(paths), len(seen)))
        last_time = np.array([[path.seen[-1]['time']] for path in paths])
        since = np.minimum(seen['time'] - last_time, LONGEST_GUESS)
        velocity = np.array([path.velocity for path in paths])
        speed = np.array([[np.linalg.norm(each)] for each in velocity])
        last = np.array([path.seen[-1]['place'] for path in paths])
        colours = np.array([path.colour for path in paths])
        ways = seen['place'] - last[:, np.newaxis]
        expected = velocity[:, np.newaxis] * since[..., np.newaxis]
        off, way = np.linalg.norm(ways - expected, axis=-1), np.linalg.norm(ways, axis=-1)
        other = np.linalg.norm(seen['colour'] - colours[:, np.newaxis], axis=-1) / COLOUR
        far = off / (NEAR + TURN * speed * since)
        reach = GATE + FASTEST * since
        costs: Floats = np.minimum(far**2, MOST_FAR) + 2.0 * other**2 + 20.0 * off
        costs[(way > reach) | (other > MOST_COLOURS)] = np.inf
        return costs
