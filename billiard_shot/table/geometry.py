"""
What balls meet on the table, in the form that compiled code takes: numbers, then lines and arcs.

Pockets are numbered 0 to 5: corners in the quadrants (+, +), (-, +), (-, -), (+, -) of (x, y),
then the sides at y > 0 and y < 0. Each has two jaws, numbered 2 p and 2 p + 1: an arc that rounds
off the end of a nose, and the facing that goes on from it into the pocket.
"""

from collections.abc import Callable
from functools import lru_cache
import math
from typing import Any, NamedTuple, ParamSpec, TypeVar

from billiard_shot.records import Floats, OBJECTS, record, Storage
from billiard_shot.table.contact_duration import stiffness_of
from billiard_shot.table.cue import CueParams, NO_CUE
from billiard_shot.table.params import BallClothParams, GATE_ON, Mouth, TableParams
from billiard_shot.table.rebound_table import room_for_rebounds

POCKETS = 6

P = ParamSpec('P')
R = TypeVar('R')


def _kept(function: Callable[P, R]) -> Callable[P, R]:
    """Keep the last results of a function; callers must not modify them."""
    kept: Any = lru_cache(maxsize=64)(function)
    return kept


@record
class TableNumbers:
    """A table, and how balls meet it and each other; lengths in m."""

    endless: bool  # there are no cushions
    centre_half_length: float  # of where a lying ball's centre can be
    centre_half_width: float
    nose_standoff: float  # horizontal distance from a nose at which a lying ball touches it
    nose_half_length: float  # of the rectangle of the noses
    nose_half_width: float
    corner_end: float  # from the corner to the straight nose's end, along the nose; 0: no pockets
    side_end: float  # from the middle of a long side to the straight nose's end
    nose_height: float
    cushion_depth: float
    cushion_model: int
    cushion_restitution: float
    cushion_friction: float
    cushion_early_fading: float  # s/m, of the restitution, from low speeds on
    cushion_fading: float  # s/m, of the restitution, at high speeds
    cushion_frequency_ratio: float  # of the tangential spring to the normal one; 0: none
    cushion_stiffness: float  # for a strike on a ball that touches a cushion
    cushion_duration: float  # s, of a contact; 0: none
    ball_restitution: float
    friction_fast: float
    friction_slow: float
    friction_decay: float
    ball_stiffness: float
    ball_duration: float  # s, of a contact of two balls that meet at `DURATION_SPEED`
    impact_stiffness: float  # N/m^exponent, of balls with that duration
    contact_gap: float
    pair_gate: int
    hop_tolerance: float  # for leaving out hops after impacts


# Fields of `TableParams` that `TableNumbers` repeats.
_SHARED = tuple(name for name in TableParams._fields if hasattr(TableNumbers, name))


@record
class Jaw:
    """An arc at the end of a nose, and the facing that goes on from it [m]."""

    arc_x: float  # centre
    arc_y: float
    arc_radius: float
    start_x: float  # of the facing
    start_y: float
    end_x: float
    end_y: float
    normal_x: float  # of the facing, a unit vector into the mouth
    normal_y: float


@record
class PocketGeometry:
    """A hole, and the rectangle in which a ball's centre can meet anything of the pocket [m]."""

    hole_x: float  # centre
    hole_y: float
    hole_radius: float
    bounds_x: float  # centre
    bounds_y: float
    bounds_half_length: float
    bounds_half_width: float


class TableModel(NamedTuple):
    """All that a simulation takes of a table."""

    params: BallClothParams
    numbers: TableNumbers
    jaws: list[Jaw]  # 12, or none
    pockets: list[PocketGeometry]  # 6, or none
    rebounds: Floats  # see rebound_table.py; empty: all rebounds are solved
    cue: CueParams
    tolerance: float = 1.0  # m, for leaving out bounces of a ball that flies
    roll_tolerance: float = 1.0  # m, for dividing rolls, see rolling.py


class PackedTable(NamedTuple):
    """A `TableModel` as compiled code is given it: to pass a record of its own takes long."""

    params: BallClothParams
    numbers: list[TableNumbers]  # 1
    jaws: list[Jaw]
    pockets: list[PocketGeometry]
    rebounds: Floats
    cue: CueParams


def table_of(layout: PackedTable) -> TableModel:
    """Return the table that is laid out; for Python, because numba cannot return a record."""
    return TableModel(layout.params, layout.numbers[0], *layout[2:])


@_kept
def lay_out(
    storage: Storage,
    params: BallClothParams,
    table: TableParams,
    hop_tolerance: float = 1.0,
    fast_rebounds: bool = False,
    cue: CueParams = NO_CUE,
) -> PackedTable:
    """
    Lay out a table; not to be changed.

    `hop_tolerance` [m] is for simulations, see `TableNumbers`; for `fast_rebounds` see
    `TableTask`.
    """
    numbers: list[TableNumbers] = storage.records(TableNumbers, 1)
    n = numbers[0]
    standoff = _standoff(table, params.radius)
    n.endless = table.length == math.inf
    n.nose_standoff = standoff
    n.centre_half_length = 0.5 * table.length - standoff
    n.centre_half_width = 0.5 * table.width - standoff
    n.nose_half_length = n.centre_half_length + standoff
    n.nose_half_width = n.centre_half_width + standoff
    if table.pockets:
        n.corner_end = math.sqrt(0.5) * table.corner[0] + table.corner[4]
        n.side_end = 0.5 * table.side[0] + table.side[4]
    for name in _SHARED:
        setattr(n, name, getattr(table, name))
    if table.ball_duration > 0.0:
        n.impact_stiffness = stiffness_of(params.mass, table.ball_duration, params.exponent)
    n.hop_tolerance = hop_tolerance
    sine = (n.nose_height - params.radius) / params.radius
    rebounds = (
        room_for_rebounds(storage, params, table, sine) if fast_rebounds else storage.zeros(0)
    )
    return PackedTable(params, numbers, *edges_of(storage, table, params.radius), rebounds, cue)


def edges_of(
    storage: Storage, table: TableParams, radius: float
) -> tuple[list[Jaw], list[PocketGeometry]]:
    """Lay out the jaws and pockets of a table for balls of a radius [m]."""
    count = POCKETS if table.pockets else 0
    jaws: list[Jaw] = storage.records(Jaw, 2 * count)
    pockets: list[PocketGeometry] = storage.records(PocketGeometry, count)
    x, y = 0.5 * table.length, 0.5 * table.width
    at_corner = math.sqrt(0.5) * table.corner[0]
    out = math.sqrt(0.5) * table.corner_hole[0]
    half = 0.5 * table.side[0]
    for i in range(count):
        one, other, pocket = jaws[2 * i], jaws[2 * i + 1], pockets[i]
        if i < 4:
            sx = 1.0 if i in (0, 3) else -1.0
            sy = 1.0 if i < 2 else -1.0
            place_jaw(
                table, one, table.corner, sx * (x - at_corner), sy * y, sx, dy=0.0, ox=0.0, oy=sy
            )
            place_jaw(
                table, other, table.corner, sx * x, sy * (y - at_corner), 0.0, dy=sy, ox=sx, oy=0.0
            )
            pocket.hole_x, pocket.hole_y = sx * (x + out), sy * (y + out)
            pocket.hole_radius = table.corner_hole[1]
        else:
            sy = 1.0 if i == 4 else -1.0
            place_jaw(table, one, table.side, half, sy * y, -1.0, dy=0.0, ox=0.0, oy=sy)
            place_jaw(table, other, table.side, -half, sy * y, 1.0, dy=0.0, ox=0.0, oy=sy)
            pocket.hole_x, pocket.hole_y = 0.0, sy * (y + table.side_hole[0])
            pocket.hole_radius = table.side_hole[1]
        bound_pocket(pocket, (one, other), _standoff(table, radius))
        if table.pocket_gate == GATE_ON:
            pocket.bounds_half_length, pocket.bounds_half_width = math.inf, math.inf
    return jaws, pockets


def place_jaw(
    table: TableParams,
    jaw: Jaw,
    mouth: Mouth,
    x: float,
    y: float,
    dx: float,
    dy: float,
    ox: float,
    oy: float,
) -> None:
    """Place a jaw whose nose runs along d to (x, y), where its line meets the facing's; o: out."""
    _, sine, cosine, radius, setback = mouth
    fx, fy = cosine * dx + sine * ox, cosine * dy + sine * oy
    jaw.arc_x = x - setback * dx + radius * ox
    jaw.arc_y = y - setback * dy + radius * oy
    jaw.arc_radius = radius
    jaw.start_x = x + setback * fx
    jaw.start_y = y + setback * fy
    jaw.end_x = x + table.cushion_depth / sine * fx
    jaw.end_y = y + table.cushion_depth / sine * fy
    jaw.normal_x = sine * dx - cosine * ox
    jaw.normal_y = sine * dy - cosine * oy


def bound_pocket(pocket: PocketGeometry, jaws: tuple[Jaw, Jaw], standoff: float) -> None:
    """Find the rectangle in which a ball's centre can meet anything of the pocket."""
    centres = [(pocket.hole_x, pocket.hole_y, pocket.hole_radius)]
    for jaw in jaws:
        centres += [
            (jaw.arc_x, jaw.arc_y, jaw.arc_radius + standoff),
            (jaw.start_x, jaw.start_y, standoff),
            (jaw.end_x, jaw.end_y, standoff),
        ]
    low_x, high_x = min(x - r for x, _, r in centres), max(x + r for x, _, r in centres)
    low_y, high_y = min(y - r for _, y, r in centres), max(y + r for _, y, r in centres)
    pocket.bounds_x, pocket.bounds_y = 0.5 * (low_x + high_x), 0.5 * (low_y + high_y)
    pocket.bounds_half_length = 0.5 * (high_x - low_x)
    pocket.bounds_half_width = 0.5 * (high_y - low_y)


def layout_of(params: BallClothParams, table: TableParams) -> TableModel:
    """Lay out a table for those who look at it, but simulate nothing."""
    return table_of(lay_out(OBJECTS, params, table))


def _standoff(table: TableParams, radius: float) -> float:
    above = table.nose_height - radius
    return math.sqrt(radius * radius - above * above)
