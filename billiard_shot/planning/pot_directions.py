"""
The directions in which a ball rolls straight into a pocket.

They are an interval: the opening of the pocket (pocket_openings.py), less the directions in which
other balls block the path.
"""

from enum import IntEnum
import math
from typing import Any, NamedTuple

import numpy as np

from billiard_shot.compiled import inner
from billiard_shot.numerics.angles import wrapped
from billiard_shot.planning.pocket_openings import ANGLE_STEP, ANGLE_STEPS, ANGLES, HOLE_SPEEDS
from billiard_shot.records import Floats, Storage
from billiard_shot.table.geometry import (
    lay_out,
    PocketGeometry,
    POCKETS,
    TableNumbers,
)
from billiard_shot.table.params import BallClothParams, GATE_AUTO
from billiard_shot.table.scene_params import ENDLESS


class BallKind(IntEnum):
    """How a ball is there for a direct shot."""

    NO_BALL = 0  # not on the table
    PRESENT = 1
    LEGAL = 2  # also a target


NO_BALL, PRESENT, LEGAL = map(int, BallKind)
ARRIVALS = 1.0, 0.5, 2.0  # m/s, of the ball at the pocket; the best one often comes first
CORNERS = 4
SPEED_0, SPEED_COUNT = float(HOLE_SPEEDS[0]), len(HOLE_SPEEDS)


class Seen(NamedTuple):
    """One table: its balls, its pockets, and what balls roll on."""

    params: BallClothParams
    numbers: TableNumbers
    holes: list[PocketGeometry]  # POCKETS
    openings: Floats  # see `openings_of`
    axes: Floats  # (POCKETS,) directions into the pockets [rad]
    places: Floats  # (balls, 2) m
    kinds: Any  # (balls,) ints: NO_BALL, PRESENT or LEGAL


class Directions(NamedTuple):
    """An interval of directions [rad], from ahead + low to ahead + high; none if high <= low."""

    ahead: float
    low: float
    high: float


class Pot(NamedTuple):
    """How a ball can be sent straight into a pocket."""

    way: float  # m, to the middle of the hole
    into: float  # rad, middle of the directions in which it falls
    half: float  # rad, half the width of the interval of directions; 0 or less: there are none


@inner
def pot_of(seen: Seen, ball: int, pocket: int, cue: int, arrival: float) -> Pot:
    """
    Find the directions in which a ball rolls into a pocket, where it arrives at a speed [m/s].

    The cue ball is not in the way; if its place is not known, `cue` is the ball itself.
    """
    x, y = seen.places[ball][0], seen.places[ball][1]
    u, v = seen.holes[pocket].hole_x - x, seen.holes[pocket].hole_y - y
    way = math.sqrt(u * u + v * v)
    if way == 0.0:
        return Pot(0.0, 0.0, 0.0)
    falls = opening_of(seen, pocket, math.atan2(v, u), way, arrival)
    if falls.high <= falls.low:
        return Pot(way, falls.ahead, 0.0)
    free = free_directions(seen, cue, ball, x, y, way, falls)
    return Pot(way, free.ahead + 0.5 * (free.low + free.high), 0.5 * (free.high - free.low))


@inner
def opening_of(
    seen: Seen, pocket: int, direction: float, way: float, arrival: float
) -> Directions:
    """Find the directions near one [rad] in which a ball at a way [m] from a pocket falls in."""
    angle = wrapped(direction - seen.axes[pocket])
    octave = min(max(math.log2(arrival / SPEED_0), 0.0), SPEED_COUNT - 1.0)
    low, high = 0.0, 0.0
    for _ in range(2):  # the ends of the opening depend on the direction a little
        low = math.asin(max(edge_of(seen, pocket, angle + low, octave, 0) / way, -1.0))
        high = math.asin(min(edge_of(seen, pocket, angle + high, octave, 1) / way, 1.0))
        if high <= low:
            break
    return Directions(direction, low, high)


@inner
def edge_of(seen: Seen, pocket: int, angle: float, octave: float, end: int) -> float:
    """Interpolate an end of an opening [m] at an angle from its axis; see `openings_of`."""
    x = angle / ANGLE_STEP + ANGLE_STEPS
    if not 0.0 <= x <= ANGLES - 1:
        return 0.0
    i, j = min(int(x), ANGLES - 2), min(int(octave), SPEED_COUNT - 2)
    x, y = x - i, octave - j
    of_kind = seen.openings[0] if pocket < CORNERS else seen.openings[1]
    a = of_kind[i][j][end] * (1.0 - y) + of_kind[i][j + 1][end] * y
    b = of_kind[i + 1][j][end] * (1.0 - y) + of_kind[i + 1][j + 1][end] * y
    return a * (1.0 - x) + b * x


@inner
def free_directions(
    seen: Seen, besides: int, besides_too: int, x: float, y: float, way: float, wanted: Directions
) -> Directions:
    """
    Cut an interval of directions to those that no ball blocks.

    Parameters
    ----------
    seen : Seen
    besides, besides_too : int
        Balls that are not in the way.
    x, y : float
        Where the path begins [m].
    way : float
        Length of the path [m].
    wanted : Directions

    Returns
    -------
    Directions
        The part around `wanted.ahead`; none if a ball blocks that direction.

    """
    diameter, (ahead, low, high) = 2.0 * seen.params.radius, wanted
    along_x, along_y = math.cos(ahead), math.sin(ahead)
    for k in range(len(seen.kinds)):
        if k in (besides, besides_too) or seen.kinds[k] == NO_BALL:
            continue
        u, v = seen.places[k][0] - x, seen.places[k][1] - y
        along, aside = u * along_x + v * along_y, v * along_x - u * along_y
        if along <= 0.0 or along > way + diameter:
            continue
        if abs(aside) > diameter + 1.5 * along * max(high, -low):
            continue
        square = u * u + v * v
        angle = math.atan2(aside, along)
        half = math.asin(min(diameter / math.sqrt(square), 1.0))
        if abs(angle) < half:
            if along - math.sqrt(max(diameter * diameter - aside * aside, 0.0)) < way:
                return Directions(ahead, 0.0, 0.0)
        elif square - diameter * diameter < way * way:
            if angle > 0.0:
                high = min(high, angle - half)
            else:
                low = max(low, angle + half)
    return Directions(ahead, low, high)


@inner
def ball_fits(seen: Seen, x: float, y: float) -> bool:
    """Whether a ball at a place [m] is between the cushions."""
    numbers = seen.numbers
    return abs(x) <= numbers.centre_half_length and abs(y) <= numbers.centre_half_width


def example_tables(storage: Storage) -> tuple[Any, ...]:
    """Make a layout, and openings, axes, places and kinds as entries take them; see `Seen`."""
    params = BallClothParams(*(1.0,) * 10, 0, 1.0, GATE_AUTO, GATE_AUTO)
    return (
        lay_out(storage, params, ENDLESS),
        storage.zeros(2, ANGLES, SPEED_COUNT, 2),
        storage.zeros(POCKETS),
        storage.array(np.zeros((1, 1, 2))),
        storage.array(np.zeros((1, 1), np.int64)),
    )
