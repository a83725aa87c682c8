"""The places of an atlas: where the ball to be potted lies, and where the cue ball."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.numerics import rounding
from billiard_shot.planning.atlas.request import AtlasRequest, settled
from billiard_shot.planning.targets import Point
from billiard_shot.scene import Scene, Table
from billiard_shot.scene.placing import CUE_BALL, no_place

DIGITS = 6  # after the point, of places in m: exact enough for a ball, and short in files


class Place(NamedTuple):
    """Where two balls lie [m]."""

    ball: str
    ball_place: Point
    cue_place: Point


def places_of(scene: Scene, request: AtlasRequest) -> tuple[Place, ...]:
    """
    List the places of an atlas: those of its grids where there is room for the balls.

    Other balls of the scene stay where they are.

    Raises
    ------
    ValueError
        If the request does not fit the scene, or there is no room at all.

    """
    request = settled(scene, request)
    assert scene.table is not None
    cue_places = grid(scene.table, scene.ball.radius, request.cue_grid)
    places = []
    for ball in request.ball:
        others = [there for name, there in scene.balls.items() if name not in (ball, CUE_BALL)]
        for there, here in product(_ball_places(scene, request, ball), cue_places):
            if _room(scene, there, others) and _room(scene, here, [*others, there]):
                places.append(Place(ball, there, here))
    if not places:
        raise ValueError(
            f'atlas: cue_grid: {request.cue_grid} is not allowed; at none of its places there is '
            'room for the cue ball beside the other balls'
        )
    return tuple(places)


def grid(table: Table, radius: float, counts: tuple[int, int]) -> tuple[Point, ...]:
    """Middles of equal fields that fill the room for balls of a radius, row by row [m]."""
    x, y = (lines[:-1] + 0.5 * np.diff(lines) for lines in borders(table, radius, counts))
    return tuple(
        (round(float(a), DIGITS) + 0.0, round(float(b), DIGITS) + 0.0) for b in y for a in x
    )


def borders(
    table: Table, radius: float, counts: tuple[int, int]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lines between these fields along x and along y, one more than there are fields [m]."""
    x, y = 0.5 * table.length - radius, 0.5 * table.width - radius
    return np.linspace(-x, x, counts[0] + 1), np.linspace(-y, y, counts[1] + 1)


def scene_at(scene: Scene, place: Place) -> Scene:
    """Put the two balls of a place into a scene."""
    moved = {place.ball: place.ball_place, CUE_BALL: place.cue_place}
    return replace(scene, balls={**scene.balls, **moved}, rack=None)


def _ball_places(scene: Scene, request: AtlasRequest, ball: str) -> Sequence[Point]:
    if request.ball_grid and scene.table:
        places = grid(scene.table, scene.ball.radius, request.ball_grid)
        return sorted(places, key=lambda place: -place[1])  # as one reads, seen from above
    return request.ball_at or (scene.balls[ball],)


def _room(scene: Scene, place: Point, others: list[Point]) -> bool:
    least = 2.0 * scene.ball.radius - rounding.PLACE
    return not no_place(scene.table, *place, scene.ball.radius) and all(
        math.dist(place, other) >= least for other in others
    )
