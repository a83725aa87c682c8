"""
Places where balls can lie, from sightings with errors.

Balls that touch each other or a cushion are seen to overlap by the errors of the camera. They are
moved as little as possible, so that they do not.
"""

from collections.abc import Iterator
from itertools import combinations, product

import numpy as np

from billiard_shot.perception.sightings import Balls, SURE_SIGMAS
from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import no_place, nose_standoff
from billiard_shot.scene.rack import Place

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
    standoff = nose_standoff(scene.table.cushion, scene.ball.radius)
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
