"""
The openings of pockets: how far beside the middle of a hole a ball may roll, and still fall.

A ball rolls towards a hole along a straight line. The opening is the longest interval of distances
of this line from the middle of the hole, from its first to its last line of which the ball falls.
It depends on the kind of pocket, on the direction, and on the speed, and it is simulated, jaws
included. What falls after a rebound from elsewhere is not part of it.
"""

from functools import lru_cache
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array
from billiard_shot.table.geometry import layout_of
from billiard_shot.table.initial_states import ball_starts
from billiard_shot.table.params import BallClothParams, TableParams
from billiard_shot.table.simulate import run_many
from billiard_shot.table.task import TableTask

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
    starts['absent'][:, 0] = (np.abs(begin) > half).any(axis=1)
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
