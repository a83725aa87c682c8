"""From strikes to the table: where all balls are then, and how they and the cue move."""

import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.numerics import rounding
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, no_place
from billiard_shot.shot.accuracy import HOPS
from billiard_shot.shot.strike import Strikes, Strokes
from billiard_shot.table.params import TableParams
from billiard_shot.table.run import EventLog
from billiard_shot.table.simulate import TableTask


def check_place(scene: Scene, centre: NDArray[np.float64]) -> None:
    """Raise ValueError if the cue ball cannot be there, because another one is, or a cushion."""
    x, y = float(centre[0]), float(centre[1])
    for name, (other_x, other_y) in scene.balls.items():
        overlap = 2.0 * scene.ball.radius - np.hypot(x - other_x, y - other_y)
        if name != CUE_BALL and overlap > rounding.PLACE:
            raise ValueError(
                f'position must be at least {2e3 * scene.ball.radius:.4g} mm from ball {name!r}, '
                f'got ({x:g}, {y:g}), an overlap of {1e3 * overlap:.3g} mm'
            )
    if scene.table is not None and (why := no_place(scene.table, x, y, scene.ball.radius)):
        raise ValueError(f'position must be {why}, got ({x:g}, {y:g}) (m)')


def names_of(scene: Scene) -> tuple[str, ...]:
    """Names of all balls: the cue ball, and the others in the scene's order."""
    return CUE_BALL, *(name for name in scene.balls if name != CUE_BALL)


def others_in(scene: Scene) -> NDArray[np.float64]:
    """Places (balls, 3) [m] of all balls but the cue ball, in the order of `names_of`."""
    places = [
        (*place, scene.ball.radius) for name, place in scene.balls.items() if name != CUE_BALL
    ]
    return np.array(places, float).reshape(-1, 3)


def table_task(
    strokes: Strokes,
    strikes: Strikes,
    table: TableParams,
    tolerance: float,
    hops: float = HOPS,
) -> TableTask:
    """
    Put the balls onto the table as strikes leave them, and let the cues follow their strokes.

    Parameters
    ----------
    strokes : Strokes
    strikes : Strikes
        Of these strokes.
    table : TableParams
    tolerance : float
        Of the trajectories [m].
    hops : float
        Share of the tolerance for hops that are left out.

    """
    model, starts = strokes.model, strikes.starts
    if not model.table:  # the ball, which may go down, is put onto the cloth
        down = starts['velocity'][:, 0, 2]
        np.maximum(down, 0.0, out=down)
    return TableTask(
        model.surface,
        table,
        starts,
        hops * tolerance,
        cue=strikes.params,
        cues=strikes.cues,
    )


def is_endless(table: TableParams) -> bool:
    """Whether there are no cushions."""
    return math.isinf(table.length)


def joined_events(strike: EventLog, run: EventLog) -> EventLog:
    """Put the meetings of balls that are part of a strike before the events of its run."""
    if not len(strike.rows):
        return run
    participants = run.participants + np.array([len(strike.rows), 0])
    return EventLog(np.concatenate([strike.rows, run.rows]), participants)
