"""The cue ball in hand: places from which a ball is likely to be potted, and for breaks."""

from collections.abc import Mapping
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.limits import Limits
from billiard_shot.planning.shots import DirectShots, shots
from billiard_shot.planning.statistics import quasi_random
from billiard_shot.planning.targets import Break, Pot, Target
from billiard_shot.records import Array
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.placement import CUE_BALL, head_string, no_place
from billiard_shot.scene.player import AZIMUTH
from billiard_shot.scene.rack import Place
from billiard_shot.scene.table import Table
from billiard_shot.table.run import POCKET_NAMES
from billiard_shot.table.table_states import TableStates

IN_HAND_PLACES = 'anywhere', 'kitchen'
TRIED = 1500  # places that are rated
PLACE_SPACING = 0.15  # m, at least, between the places that are chosen
NEAREST = 0.15  # m to the ball: from nearer the cue may hit the cue ball twice
ALIKE = 0.01  # chance: among places that differ by less, the one with the shortest ways is better
# Places of breaks: table lengths behind the head string; table widths beside the middle, at most.
BREAK_BEHIND, BREAK_BESIDE = 0.02, 0.4


def places_in_hand(
    scene: Scene, target: Target, limits: Limits, noise: Noise, place: str, count: int
) -> list[tuple[float, float]]:
    """
    Choose places of the cue ball (x, y) [m], the best first.

    For a pot, those from which a direct shot pots the ball. For a break, places in the kitchen,
    from the middle of the head string to the side.

    Parameters
    ----------
    scene : Scene
    target : Target
    limits : Limits
    noise : Noise
    place : str
        `anywhere` on the table, or in the `kitchen`: behind the head string.
    count : int
        Largest number of places; they are at least `PLACE_SPACING` from each other.

    Raises
    ------
    ValueError
        If `place` is not in `IN_HAND_PLACES`, or the target is neither a pot nor a break.

    """
    if place not in IN_HAND_PLACES:
        raise ValueError(f'place must be {" or ".join(IN_HAND_PLACES)}, got {place!r}')
    if not isinstance(target, Pot | Break) or scene.table is None:
        name = type(target).__name__.lower()
        raise ValueError(f'place needs the target pot or break, got the target {name}')
    others = scene.object_balls
    table, radius = scene.table, scene.ball.radius
    is_break = isinstance(target, Break)
    points = _along_head_string(table, count) if is_break else places_all_over(table, place)
    free = [(x, y) for x, y in points.tolist() if not no_place(table, x, y, radius, others)]
    if isinstance(target, Break):
        return free
    legal = [
        name
        for name in others
        if target.wants(name)
        and name not in limits.keep
        and (not limits.first_contact or name in limits.first_contact)
    ]
    found = shots(scene, cue_ball_at(np.array(free), others, radius), legal, noise)
    wanted = np.isin(found.pocket, [POCKET_NAMES.index(name) for name in target.pocket])
    wanted &= limits.allows_azimuth(found.offsets[:, AZIMUTH])
    order = best_in_hand(found)
    chosen: list[tuple[float, float]] = []
    for k in order[wanted[order]].tolist():
        here = free[found.table[k]]
        if all(math.dist(here, other) >= PLACE_SPACING for other in chosen):
            chosen.append(here)
        if len(chosen) == count:
            break
    return chosen


def _along_head_string(table: Table, count: int) -> Array:
    """List places (n, 2) [m] a little behind the head string, from its middle to the side."""
    x, y = head_string(table) - BREAK_BEHIND * table.length, BREAK_BESIDE * table.width
    return np.column_stack([np.full(count, x), np.linspace(0.0, y, count)])


def best_in_hand(direct: DirectShots) -> NDArray[np.int64]:
    """List direct shots, the best first, without those whose cue ball is too near to the ball."""
    rounded = np.round(direct.chance / ALIKE)
    order = np.lexsort((direct.distance + direct.way, -rounded))
    return order[direct.distance[order] >= NEAREST]


def cue_ball_at(places: Array, others: Mapping[str, Place], radius: float) -> TableStates:
    """Make a table for each place (n, 2) [m] of the cue ball, with the other balls as they lie."""
    position = np.full((len(places), 1 + len(others), 3), radius)
    position[:, 0, :2] = places.reshape(-1, 2)
    position[:, 1:, :2] = np.array(list(others.values())).reshape(-1, 2)
    return TableStates((CUE_BALL, *others), position)


def places_all_over(table: Any, place: str) -> Array:
    """
    List places (n, 2) [m], all over the table or the kitchen, that are tried for the cue ball.

    Parameters
    ----------
    table : Table or State
        Anything with a length and a width [m].
    place : str
        One of `IN_HAND_PLACES`.

    """
    low = -0.5 * np.array([table.length, table.width])
    high = -low
    if place == 'kitchen':
        high[0] = head_string(table)
    points: Array = low + (high - low) * quasi_random(TRIED, 2)
    return points
