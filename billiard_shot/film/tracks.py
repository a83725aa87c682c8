"""
Tracks: which ball of a picture is which one of the pictures before.

A ball is expected where its velocity takes it, and has its colour. All balls of a picture are
matched at once, with the least sum of costs (Kuhn 1955, The Hungarian method). A hidden ball keeps
its track, and is looked for in a circle that grows.
"""

from bisect import bisect_left
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from billiard_shot.film.balls import Seen
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
"""If exchanging two near balls costs less more than this, they may have been exchanged."""

LEAST_SEEN = 8
"""Fewer sights are no ball."""

ALIVE = 2.0
"""A spot that was seen fewer times is forgotten after so long [s]."""


@dataclass(slots=True, eq=False)
class Path:
    """
    What was seen of a ball; all lists have an entry for each sight.

    Attributes
    ----------
    time : list of float
        [s]
    place : list of (2,) float array
        [m]
    sigma : list of float
        [m]
    white : list of float
        Share of white.
    colour : (3,) float array
        Mean [of 255].
    spread : float
        How far colours are from it, in the mean [of 255].
    velocity : (2,) float array
        Of the last sights [m/s].

    """

    time: list[float] = field(default_factory=list)
    place: list[Floats] = field(default_factory=list)
    sigma: list[float] = field(default_factory=list)
    white: list[float] = field(default_factory=list)
    colour: Floats = field(default_factory=lambda: np.zeros(3))
    spread: float = COLOUR
    velocity: Floats = field(default_factory=lambda: np.zeros(2))

    def add(self, seen: Seen, k: int, time: float) -> None:
        """Add a sight."""
        if self.time:
            elapsed = max(time - self.time[-1], 1e-3)
            self.velocity = (seen.place[k] - self.place[-1]) / elapsed
        weight = max(1.0 / (len(self.time) + 1), 0.05)
        away = float(np.linalg.norm(seen.colour[k] - self.colour)) if self.time else COLOUR
        self.spread += weight * (away - self.spread)
        self.colour = self.colour + weight * (seen.colour[k] - self.colour)
        self.time.append(time)
        self.place.append(seen.place[k])
        self.sigma.append(float(seen.sigma[k]))
        self.white.append(float(seen.white[k]))

    def expected(self, time: float) -> Floats:
        """Return where the ball is expected [m]."""
        return self.place[-1] + self.velocity * min(time - self.time[-1], LONGEST_GUESS)


class Tracker:
    """
    Tracks balls from picture to picture.

    Parameters
    ----------
    radius : float
        Of the balls [m].

    Attributes
    ----------
    paths : list of Path
    unsure : list of (float, Path, Path)
        When two balls may have been exchanged.

    """

    def __init__(self, radius: float) -> None:
        self.paths: list[Path] = []
        self.unsure: list[tuple[float, Path, Path]] = []
        self._radius = radius

    def expected(self, time: float) -> Floats:
        """Return where balls are expected (n, 2) [m]."""
        return np.array([path.expected(time) for path in self._alive(time)]).reshape(-1, 2)

    def _alive(self, time: float) -> list[Path]:
        """Return the paths that may go on."""
        alive = []
        for path in self.paths:
            count, since = len(path.time), time - path.time[-1]
            if count >= LEAST_SEEN or since < ALIVE * count / LEAST_SEEN:
                alive.append(path)
        return alive

    def add(self, seen: Seen, time: float, times: Floats) -> None:
        """Add the balls of a picture of a time [s], each at its own time (n,) [s]."""
        paths = self._alive(time)
        costs = self._costs(paths, seen, time)
        rows, columns = linear_sum_assignment(np.minimum(costs, 1e6))
        matched = [(i, k) for i, k in zip(rows, columns, strict=True) if np.isfinite(costs[i, k])]
        self._doubt(paths, seen, time, costs, matched)
        for i, k in matched:
            paths[i].add(seen, k, float(times[k]))
        taken = {k for _, k in matched}
        for k in range(len(seen.place)):
            if k not in taken:
                self.paths.append(path := Path())
                path.add(seen, k, float(times[k]))

    def forget(self, before: float) -> None:
        """Forget the sights before a time [s], and the paths without others."""
        self.paths = [path for path in self.paths if path.time[-1] >= before]
        self.unsure.clear()
        for path in self.paths:
            old = bisect_left(path.time, before)
            for each in (path.time, path.place, path.sigma, path.white):
                del each[:old]

    def _costs(self, paths: list[Path], seen: Seen, time: float) -> Floats:
        """Return the costs (paths, balls) of matches; infinite ones cannot be."""
        if not paths or not len(seen.place):
            return np.empty((len(paths), len(seen.place)))
        since = np.array([[time - path.time[-1]] for path in paths])
        expected = np.array([path.expected(time) for path in paths])
        speed = np.array([[np.linalg.norm(path.velocity)] for path in paths])
        last = np.array([path.place[-1] for path in paths])
        colours = np.array([path.colour for path in paths])
        spreads = np.array([[max(path.spread, COLOUR)] for path in paths])
        off = np.linalg.norm(seen.place - expected[:, np.newaxis], axis=-1)
        way = np.linalg.norm(seen.place - last[:, np.newaxis], axis=-1)
        other = np.linalg.norm(seen.colour - colours[:, np.newaxis], axis=-1) / spreads
        far = off / (NEAR + TURN * speed * np.minimum(since, LONGEST_GUESS))
        reach = GATE + FASTEST * np.minimum(since, LONGEST_GUESS)
        costs: Floats = np.minimum(far**2, MOST_FAR) + 2.0 * other**2 + 20.0 * off
        costs[(way > reach) | (other > MOST_COLOURS)] = np.inf
        return costs

    def _doubt(
        self,
        paths: list[Path],
        seen: Seen,
        time: float,
        costs: Floats,
        matched: list[tuple[int, int]],
    ) -> None:
        """Note near balls in motion that could as well be exchanged."""
        for n, (i, k) in enumerate(matched):
            for j, m in matched[:n]:
                if np.linalg.norm(seen.place[k] - seen.place[m]) > 6.0 * self._radius:
                    continue
                more = costs[i, m] + costs[j, k] - costs[i, k] - costs[j, m]
                if more < UNSURE:
                    self.unsure.append((time, paths[i], paths[j]))


def merged(paths: list[Path]) -> Path:
    """Join paths that follow one another."""
    paths = sorted(paths, key=lambda path: path.time[0])
    whole = Path(colour=paths[0].colour, spread=paths[0].spread)
    for path in paths:
        whole.time += path.time
        whole.place += path.place
        whole.sigma += path.sigma
        whole.white += path.white
    return whole


def rows_of(path: Path) -> NDArray[np.float64]:
    """Return time [s], x, y and sigma [m] of a path as rows (n, 4)."""
    return np.column_stack([path.time, np.array(path.place).reshape(-1, 2), path.sigma])
