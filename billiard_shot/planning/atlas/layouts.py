"""The layouts of an atlas: positions of the ball to be potted and of the cue ball."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.atlas.request import AtlasRequest, with_defaults
from billiard_shot.scene import Scene, Table
from billiard_shot.scene.placement import CUE_BALL, no_place
from billiard_shot.scene.rack import Place

DIGITS = 6  # after the decimal point, of positions in m: exact enough for a ball


class Layout(NamedTuple):
    """Positions of the ball to be potted and of the cue ball [m]."""

    ball: str
    ball_place: Place
    cue_place: Place


def layouts_of(scene: Scene, request: AtlasRequest) -> tuple[Layout, ...]:
    """
    List the layouts of an atlas: all combinations of free positions.

    The other balls of the scene keep their positions.

    Raises
    ------
    ValueError
        If the request does not fit the scene, or no position of the cue ball is free.

    """
    request = with_defaults(scene, request)
    assert scene.table is not None
    cue_places = grid(scene.table, scene.ball.radius, request.cue_grid)
    layouts = []
    for ball in request.ball:
        others = {name: at for name, at in scene.balls.items() if name not in (ball, CUE_BALL)}
        for there, here in product(_ball_places(scene, request, ball), cue_places):
            if _is_free(scene, there, others) and _is_free(scene, here, {**others, ball: there}):
                layouts.append(Layout(ball, there, here))
    if not layouts:
        raise ValueError(
            'atlas: cue_grid must have a position that is free for the cue ball, got '
            f'{request.cue_grid}'
        )
    return tuple(layouts)


def grid(table: Table, radius: float, counts: tuple[int, int]) -> tuple[Place, ...]:
    """Centres of equal cells that fill the area of ball centres, row by row [m]."""
    x, y = (lines[:-1] + 0.5 * np.diff(lines) for lines in borders(table, radius, counts))
    return tuple(
        (round(float(a), DIGITS) + 0.0, round(float(b), DIGITS) + 0.0) for b in y for a in x
    )


def borders(
    table: Table, radius: float, counts: tuple[int, int]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Borders of these cells along x and along y [m]."""
    x, y = 0.5 * table.length - radius, 0.5 * table.width - radius
    return np.linspace(-x, x, counts[0] + 1), np.linspace(-y, y, counts[1] + 1)


def scene_at(scene: Scene, layout: Layout) -> Scene:
    """Put the two balls of a layout into a scene."""
    moved = {layout.ball: layout.ball_place, CUE_BALL: layout.cue_place}
    return replace(scene, balls={**scene.balls, **moved}, rack=None)


def _ball_places(scene: Scene, request: AtlasRequest, ball: str) -> Sequence[Place]:
    if request.ball_grid and scene.table:
        points = grid(scene.table, scene.ball.radius, request.ball_grid)
        return sorted(points, key=lambda point: -point[1])  # row by row from the top
    return request.ball_at or (scene.balls[ball],)


def _is_free(scene: Scene, point: Place, others: dict[str, Place]) -> bool:
    return not no_place(scene.table, *point, scene.ball.radius, others)
