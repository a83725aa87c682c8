"""A whole atlas: a map for each position of the ball to be potted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.atlas.build import LayoutResult
from billiard_shot.planning.atlas.layouts import grid, layouts_of
from billiard_shot.planning.atlas.request import AtlasRequest
from billiard_shot.scene import Scene
from billiard_shot.scene.rack import Place


@dataclass(frozen=True, slots=True)
class Map:
    """
    Success probability of the pot of one ball from one position.

    Attributes
    ----------
    ball : str
    ball_place : (x, y)
        [m]
    results : tuple of LayoutResult
        Of the layouts that are done, one for each position of the cue ball.
    success : (rows, columns) ndarray
        On the grid of positions of the cue ball, along y and along x; NaN where no ball can lie,
        and where the result is missing.

    """

    ball: str
    ball_place: Place
    results: tuple[LayoutResult, ...]
    success: NDArray[np.float64]

    @property
    def mean(self) -> float:
        """Mean success, NaN without results."""
        return _mean([result.success for result in self.results])

    @property
    def mean_half_width(self) -> float:
        """Mean half width of the 95 % intervals of layouts with a stroke, NaN without any."""
        intervals = [result.interval for result in self.results if result.stroke]
        return _mean([0.5 * (high - low) for low, high in intervals])


@dataclass(frozen=True, slots=True)
class Atlas:
    """A request, and the results of the layouts that are done, in any order."""

    scene: Scene
    request: AtlasRequest
    results: Sequence[LayoutResult]

    @property
    def maps(self) -> tuple[Map, ...]:
        """One map for each position of a ball to be potted, in the order of the request."""
        table = self.scene.table
        assert table is not None  # an atlas without a table is refused
        columns, rows = self.request.cue_grid
        cells = grid(table, self.scene.ball.radius, self.request.cue_grid)
        index = {point: i for i, point in enumerate(cells)}
        known = {result.layout: result for result in self.results}
        found: dict[tuple[str, Place], list[LayoutResult]] = {}
        for layout in layouts_of(self.scene, self.request):
            own = found.setdefault((layout.ball, layout.ball_place), [])
            if layout in known:
                own.append(known[layout])
        maps = []
        for (ball, there), results in found.items():
            success = np.full(columns * rows, np.nan)
            for result in results:
                success[index[result.layout.cue_place]] = result.success
            maps.append(Map(ball, there, tuple(results), success.reshape(rows, columns)))
        return tuple(maps)


def _mean(values: list[float]) -> float:
    return sum(values) / len(values) if values else math.nan
