"""Into how many pockets each ball can be sent directly, from the best place of the cue ball."""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import entry, inner
from billiard_shot.planning.pocket_openings import AXES, openings_of
from billiard_shot.planning.pot_directions import (
    ARRIVALS,
    ball_fits,
    example_tables,
    LEGAL,
    NO_BALL,
    pot_of,
    Seen,
)
from billiard_shot.planning.shots import places_and_kinds
from billiard_shot.records import Floats, Storage
from billiard_shot.scene import Scene
from billiard_shot.table.effects import params_on_table
from billiard_shot.table.geometry import lay_out, PackedTable, POCKETS
from billiard_shot.table.table_states import TableStates
from billiard_shot.table.threads import in_threads


@inner
def is_open(seen: Seen, ball: int, pocket: int) -> bool:
    """
    Whether a ball can be sent into a pocket.

    A direction to the pocket is free, and the cue ball has room where it meets the ball.
    """
    pot = pot_of(seen, ball, pocket, ball, ARRIVALS[0])
    if pot.half <= 0.0:
        return False
    diameter = 2.0 * seen.params.radius
    ghost_x = seen.places[ball][0] - diameter * math.cos(pot.into)
    ghost_y = seen.places[ball][1] - diameter * math.sin(pot.into)
    if not ball_fits(seen, ghost_x, ghost_y):
        return False
    for k in range(len(seen.kinds)):
        u, v = seen.places[k][0] - ghost_x, seen.places[k][1] - ghost_y
        if k != ball and seen.kinds[k] != NO_BALL and u * u + v * v < diameter * diameter:
            return False
    return True


def _example(storage: Storage) -> tuple[Any, ...]:
    return *example_tables(storage), storage.array(np.zeros((1, 1), np.int64))


@entry(_example)
def count_open_pockets(
    layout: PackedTable, openings: Floats, axes: Floats, places: Floats, kinds: Any, counts: Any
) -> None:
    """
    Count the open pockets of balls of many tables.

    Parameters
    ----------
    layout, openings, axes
        See `Seen`.
    places : (tables, balls, 2) floats
        Centres of the balls [m].
    kinds : (tables, balls) ints
        NO_BALL, PRESENT, or LEGAL: the balls to be looked at.
    counts : (tables, balls) ints, written

    """
    for t in range(len(places)):
        numbers, holes = layout.numbers[0], layout.pockets
        seen = Seen(layout.params, numbers, holes, openings, axes, places[t], kinds[t])
        for ball in range(len(kinds[t])):
            count = 0
            if kinds[t][ball] == LEGAL:
                for pocket in range(POCKETS):
                    if is_open(seen, ball, pocket):
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
            array(openings),
            array(AXES),
            array(places[part]),
            array(kinds[part]),
            counts,
        )
        return np.asarray(counts)

    nothing = np.zeros((0, kinds.shape[1]), np.int64)
    return np.concatenate([nothing, *in_threads(count, len(tables))])
