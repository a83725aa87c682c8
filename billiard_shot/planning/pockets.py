"""The openings of pockets, and the directions in which a ball rolls straight into one."""

from enum import IntEnum
from functools import lru_cache
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import inner
from billiard_shot.numerics.vectors import wrapped
from billiard_shot.records import Array, Floats, Storage
from billiard_shot.table.model.geometry import (
    BallClothParams,
    PocketGeometry,
    POCKETS,
    TableNumbers,
    TableParams,
)
from billiard_shot.table.model.motion import ABSENT
from billiard_shot.table.run.layout import ENDLESS, lay_out, layout_of
from billiard_shot.table.run.simulate import run_many
from billiard_shot.table.run.states import ball_starts
from billiard_shot.table.run.task import TableTask

# Directions of the axes into the pockets [rad], counter-clockwise from +x.
AXES = np.radians([45.0, 135.0, 225.0, 315.0, 90.0, -90.0])
POCKET_KINDS = 0, 4  # a corner pocket and a side pocket, whose openings are those of all six
# Angles [rad] from the axis of a pocket into it; counter-clockwise. Multiples of `ANGLE_STEP`.
ANGLE_STEP, ANGLE_STEPS = math.radians(5.0), 18
ANGLES = 2 * ANGLE_STEPS + 1
HOLE_SPEEDS = np.array([0.3, 0.6, 1.2, 2.4, 4.8])  # m/s at the hole, as a factor of two
WAY = 0.25  # m that the ball rolls to the hole
# Of the lines that are tried: largest distance [m]; number; halvings of their spacing.
WIDEST, COARSE_LINES_OF_OPENING, HALVINGS = 0.1, 21, 5


@lru_cache(maxsize=8)
def openings_of(params: BallClothParams, table: TableParams) -> Array:
    """
    Simulate the openings of a table's pockets.

    Returns
    -------
    (2, ANGLES, speeds, 2) float array
        Of `POCKET_KINDS`: the two ends of the opening, to the left of the middle of the hole as
        seen along the path [m]; both 0 if no ball falls. Not to be changed.

    """
    angles = ANGLE_STEP * (np.arange(ANGLES) - ANGLE_STEPS)
    grid = np.stack(np.meshgrid(angles, HOLE_SPEEDS, indexing='ij'), axis=-1).reshape(-1, 2)
    found = [_openings(params, table, pocket, grid) for pocket in POCKET_KINDS]
    return np.array(found).reshape(len(POCKET_KINDS), ANGLES, len(HOLE_SPEEDS), 2)


def _openings(params: BallClothParams, table: TableParams, pocket: int, grid: Array) -> Array:
    """Find the openings (n, 2) of a pocket for n angles and speeds."""
    lines = np.linspace(-WIDEST, WIDEST, COARSE_LINES_OF_OPENING)
    many = np.repeat(grid, len(lines), axis=0)
    falls = _falls(params, table, pocket, many, np.tile(lines, len(grid)))
    runs = [_longest_run(row) for row in falls.reshape(len(grid), len(lines))]
    step = lines[1] - lines[0]
    first, last = np.array(runs).T
    open_ = last >= first
    inside = np.stack([lines[first], lines[last]], axis=1)
    outside = np.stack([lines[first] - step, lines[last] + step], axis=1)
    both = np.repeat(grid, 2, axis=0)
    for _ in range(HALVINGS):
        middle = 0.5 * (inside + outside)
        fell = _falls(params, table, pocket, both, middle.ravel()).reshape(-1, 2)
        inside, outside = np.where(fell, middle, inside), np.where(fell, outside, middle)
    return np.where(open_[:, np.newaxis], 0.5 * (inside + outside), 0.0)


def _falls(
    params: BallClothParams, table: TableParams, pocket: int, grid: Array, offsets: Array
) -> NDArray[np.bool_]:
    """Find whether balls fall that roll to a pocket, at angles and speeds (n, 2), beside it."""
    layout = layout_of(params, table)
    hole, numbers = layout.pockets[pocket], layout.numbers
    heading = AXES[pocket] + grid[:, 0]
    along = np.stack([np.cos(heading), np.sin(heading)], axis=1)
    left = np.stack([-along[:, 1], along[:, 0]], axis=1)
    begin = np.array([hole.hole_x, hole.hole_y]) - WAY * along + offsets[:, np.newaxis] * left
    resistance = params.rolling_resistance + params.rolling_rise * grid[:, 1]
    slowing = 2.0 * resistance * params.gravity * WAY
    velocity = np.sqrt(grid[:, 1] ** 2 + slowing)[:, np.newaxis] * along
    half = np.array([numbers.centre_half_length, numbers.centre_half_width])
    starts = ball_starts(len(grid), 1)
    starts['position'][:, 0, :2], starts['position'][:, 0, 2] = begin, params.radius
    starts['velocity'][:, 0, :2] = velocity
    starts['spin'][:, 0, 0] = -velocity[:, 1] / params.radius
    starts['spin'][:, 0, 1] = velocity[:, 0] / params.radius
    starts['motion'][(np.abs(begin) > half).any(axis=1), 0] = ABSENT
    played = run_many(
        TableTask(params, table, starts, OPENING_TOLERANCE, OPENING_TOLERANCE), ('1',)
    )
    falls: NDArray[np.bool_] = played.pocket[:, 0] == pocket
    return falls


OPENING_TOLERANCE = 2e-3  # m, of these simulations


def _longest_run(row: NDArray[np.bool_]) -> tuple[int, int]:
    """First and last index of the longest run of true values; (0, -1) if there is none."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], row, [False]])))
    if not len(edges):
        return 0, -1
    begins, ends = edges[::2], edges[1::2]
    longest = int(np.argmax(ends - begins))
    return int(begins[longest]), int(ends[longest]) - 1


class BallKind(IntEnum):
    """How a ball is there for a direct shot."""

    NO_BALL = 0  # not on the table
    PRESENT = 1
    LEGAL = 2  # also a target


NO_BALL, PRESENT, LEGAL = map(int, BallKind)
ARRIVALS = 1.0, 0.5, 2.0  # m/s, of the ball at the pocket; the best one often comes first
CORNERS = 4
SPEED_0, SPEED_COUNT = float(HOLE_SPEEDS[0]), len(HOLE_SPEEDS)


class TableView(NamedTuple):
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


class PotInterval(NamedTuple):
    """How a ball can be sent straight into a pocket."""

    way: float  # m, to the middle of the hole
    into: float  # rad, middle of the directions in which it falls
    half: float  # rad, half the width of the interval of directions; 0 or less: there are none


@inner
def pot_of(seen: TableView, ball: int, pocket: int, cue: int, arrival: float) -> PotInterval:
    """
    Find the directions in which a ball rolls into a pocket, where it arrives at a speed [m/s].

    The cue ball is not in the way; if its place is not known, `cue` is the ball itself.
    """
    x, y = seen.places[ball][0], seen.places[ball][1]
    u, v = seen.holes[pocket].hole_x - x, seen.holes[pocket].hole_y - y
    way = math.sqrt(u * u + v * v)
    if way == 0.0:
        return PotInterval(0.0, 0.0, 0.0)
    falls = opening_of(seen, pocket, math.atan2(v, u), way, arrival)
    if falls.high <= falls.low:
        return PotInterval(way, falls.ahead, 0.0)
    free = free_directions(seen, cue, ball, x, y, way, falls)
    return PotInterval(
        way, free.ahead + 0.5 * (free.low + free.high), 0.5 * (free.high - free.low)
    )


@inner
def opening_of(
    seen: TableView, pocket: int, direction: float, way: float, arrival: float
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
def edge_of(seen: TableView, pocket: int, angle: float, octave: float, end: int) -> float:
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
    seen: TableView,
    besides: int,
    besides_too: int,
    x: float,
    y: float,
    way: float,
    wanted: Directions,
) -> Directions:
    """
    Cut an interval of directions to those that no ball blocks.

    Parameters
    ----------
    seen : TableView
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
def ball_fits(seen: TableView, x: float, y: float) -> bool:
    """Whether a ball at a place [m] is between the cushions."""
    numbers = seen.numbers
    return abs(x) <= numbers.centre_half_length and abs(y) <= numbers.centre_half_width


def example_tables(storage: Storage) -> tuple[Any, ...]:
    """Make a layout, and openings, axes, places and kinds as entries take them (`TableView`)."""
    params = BallClothParams(*(1.0,) * 10, 0, 1.0)
    return (
        lay_out(storage, params, ENDLESS),
        storage.zeros(2, ANGLES, SPEED_COUNT, 2),
        storage.zeros(POCKETS),
        storage.array(np.zeros((1, 1, 2))),
        storage.array(np.zeros((1, 1), np.int64)),
    )
