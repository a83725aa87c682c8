"""An atlas as a whole: a map for each place of the ball that is to be potted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.atlas.places import grid, places_of
from billiard_shot.planning.atlas.request import AtlasRequest
from billiard_shot.planning.atlas.survey import PlaceChance
from billiard_shot.planning.targets import Point
from billiard_shot.scene import Scene


@dataclass(frozen=True, slots=True)
class Map:
    """
    How surely one ball is potted from one place of it.

    Attributes
    ----------
    ball : str
    ball_place : (x, y)
        [m]
    chances : tuple of PlaceChance
        One for each place of the cue ball that is done.
    success : (rows, columns) ndarray
        On the grid of the cue ball's places, along y and along x; NaN where no ball can lie, or
        where it is not done.

    """

    ball: str
    ball_place: Point
    chances: tuple[PlaceChance, ...]
    success: NDArray[np.float64]

    @property
    def mean(self) -> float:
        """Average of the chances, NaN if none is done."""
        return _mean([chance.success for chance in self.chances])

    @property
    def doubt(self) -> float:
        """Average half width of their intervals of 95 %, where there is a stroke; else NaN."""
        intervals = [chance.interval for chance in self.chances if chance.stroke]
        return _mean([0.5 * (high - low) for low, high in intervals])


@dataclass(frozen=True, slots=True)
class Atlas:
    """What was asked for, and the places that are done, in any order."""

    scene: Scene
    request: AtlasRequest
    chances: Sequence[PlaceChance]

    @property
    def maps(self) -> tuple[Map, ...]:
        """One for each place of a ball that is to be potted, in the order of the request."""
        table = self.scene.table
        assert table is not None  # an atlas without a table is refused
        columns, rows = self.request.cue_grid
        fields = grid(table, self.scene.ball.radius, self.request.cue_grid)
        index = {place: i for i, place in enumerate(fields)}
        known = {chance.place: chance for chance in self.chances}
        found: dict[tuple[str, Point], list[PlaceChance]] = {}
        for place in places_of(self.scene, self.request):
            own = found.setdefault((place.ball, place.ball_place), [])
            if place in known:
                own.append(known[place])
        maps = []
        for (ball, there), chances in found.items():
            success = np.full(columns * rows, np.nan)
            for chance in chances:
                success[index[chance.place.cue_place]] = chance.success
            maps.append(Map(ball, there, tuple(chances), success.reshape(rows, columns)))
        return tuple(maps)


def _mean(values: list[float]) -> float:
    return sum(values) / len(values) if values else math.nan
