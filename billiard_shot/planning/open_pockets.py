"""Into how many pockets each ball can be sent directly, from the best place of the cue ball."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.planning.direct_shots import (
    ARRIVALS,
    edge_of,
    example_layout,
    free_part,
    LEGAL,
    NO_BALL,
    Seen,
    turned,
)
from billiard_shot.planning.pocket_openings import ANGLES, AXES, HOLE_SPEEDS, openings_of
from billiard_shot.planning.shots import places_and_kinds
from billiard_shot.records import Floats, Storage
from billiard_shot.scene import Scene
from billiard_shot.table.effects import params_on_table
from billiard_shot.table.geometry import lay_out, PackedTable, PocketGeometry, POCKETS
from billiard_shot.table.table_states import TableStates
from billiard_shot.table.threads import in_threads


@inner
def is_open(
    seen: Seen, openings: Floats, hole: PocketGeometry, pocket: int, axis: float, ball: int
) -> bool:
    """
    Whether a ball can be sent into a pocket.

    A direction to the pocket is free, and the cue ball has room where it meets the ball.
    """
    x, y = seen.places[ball][0], seen.places[ball][1]
    u, v = hole.hole_x - x, hole.hole_y - y
    way, into = math.sqrt(u * u + v * v), math.atan2(v, u)
    if way == 0.0:
        return False
    angle = turned(into - axis)
    low = edge_of(openings, pocket, angle, ARRIVALS[1], 0) / way
    high = edge_of(openings, pocket, angle, ARRIVALS[1], 1) / way
    if high <= low:
        return False
    low, high = free_part(
        seen, ball, ball, x, y, way, ahead=into, low=max(low, -1.0), high=min(high, 1.0)
    )
    if high <= low:
        return False
    into += 0.5 * (low + high)
    diameter, numbers = 2.0 * seen.params.radius, seen.numbers
    ghost_x, ghost_y = x - diameter * math.cos(into), y - diameter * math.sin(into)
    if abs(ghost_x) > numbers.centre_half_length or abs(ghost_y) > numbers.centre_half_width:
        return False
    for k in range(len(seen.kinds)):
        u, v = seen.places[k][0] - ghost_x, seen.places[k][1] - ghost_y
        if k != ball and seen.kinds[k] != NO_BALL and u * u + v * v < diameter * diameter:
            return False
    return True


def _example(storage: Storage) -> tuple[Any, ...]:
    return (
        example_layout(storage),
        storage.array(np.zeros((1, 1, 2))),
        storage.array(np.zeros((1, 1), np.int64)),
        storage.zeros(2, ANGLES, len(HOLE_SPEEDS), 2),
        storage.zeros(POCKETS),
        storage.array(np.zeros((1, 1), np.int64)),
    )


@entry(_example)
def count_open_pockets(
    layout: PackedTable, places: Floats, kinds: Any, openings: Floats, axes: Floats, counts: Any
) -> None:
    """
    Count the open pockets of balls of many tables.

    Parameters
    ----------
    layout : PackedTable
    places : (tables, balls, 2) floats
        Centres of the balls [m].
    kinds : (tables, balls) ints
        NO_BALL, PRESENT, or LEGAL: the balls to be looked at.
    openings : floats
        See `openings_of`.
    axes : (POCKETS,) floats
        Directions into the pockets [rad].
    counts : (tables, balls) ints, written

    """
    for t in range(len(places)):
        seen = Seen(layout.params, layout.numbers[0], places[t], kinds[t])
        for ball in range(len(kinds[t])):
            count = 0
            if kinds[t][ball] == LEGAL:
                for pocket in range(POCKETS):
                    hole = layout.pockets[pocket]
                    if is_open(seen, openings, hole, pocket, axes[pocket], ball):
                        count += 1
            counts[t][ball] = count


def open_pockets(scene: Scene, tables: TableStates, which: NDArray[np.bool_]) -> NDArray[np.int64]:
    """
    Count the pockets into which balls can be sent.

    Parameters
    ----------
    scene : Scene
        Its table, and the radius of its balls.
    tables : TableStates
        (n,) Balls that are in the way; give them without the cue ball, which moves.
    which : (n, balls) bool array
        The balls to be looked at.

    Returns
    -------
    (n, balls) int array
        0 for the other balls.

    """
    params, table = params_on_table(scene)
    openings = openings_of(params, table)
    places, kinds = places_and_kinds(tables, which)

    def count(part: slice) -> NDArray[np.int64]:
        run = count_open_pockets.current()
        storage, array = run.storage, run.storage.array
        counts = array(np.zeros_like(kinds[part]))
        run(
            lay_out(storage, params, table),
            array(places[part]),
            array(kinds[part]),
            array(openings),
            array(AXES),
            counts,
        )
        return np.asarray(counts)

    nothing = np.zeros((0, kinds.shape[1]), np.int64)
    return np.concatenate([nothing, *in_threads(count, len(tables))])
