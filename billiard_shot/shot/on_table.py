"""From strikes to the table: where all balls are then, and how they and the cue move."""

import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.numerics import rounding
from billiard_shot.records import ROWS
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, no_place
from billiard_shot.shot.accuracy import HOPS
from billiard_shot.shot.contact_geometry import gaps_of
from billiard_shot.shot.double_hit import following_cues
from billiard_shot.shot.group_strike import may_reach, strike_group
from billiard_shot.shot.neighbours import neighbours_of
from billiard_shot.shot.strike import PHASES, Strikes, Strokes
from billiard_shot.status import Status
from billiard_shot.table.geometry import layout_of
from billiard_shot.table.initial_states import ball_starts
from billiard_shot.table.motion import Cause, Motion
from billiard_shot.table.params import TableParams
from billiard_shot.table.run import EventLog
from billiard_shot.table.simulate import TableTask
from billiard_shot.table.simulation_state import Event, kinetic_energy


def check_place(scene: Scene, centre: NDArray[np.float64]) -> None:
    """Raise ValueError if the cue ball cannot be there, because another one is, or a cushion."""
    x, y = float(centre[0]), float(centre[1])
    for name, (other_x, other_y) in scene.balls.items():
        overlap = 2.0 * scene.ball.radius - np.hypot(x - other_x, y - other_y)
        if name != CUE_BALL and overlap > rounding.PLACE:
            raise ValueError(
                f'position: ({x:g}, {y:g}) is not allowed; there it overlaps ball {name!r} by '
                f'{overlap:.3g} m'
            )
    if scene.table is not None and (why := no_place(scene.table, x, y, scene.ball.radius)):
        raise ValueError(f'position: ({x:g}, {y:g}) is not allowed; {why}')


def names_of(scene: Scene) -> tuple[str, ...]:
    """Names of all balls: the cue ball, and the others in the scene's order."""
    return CUE_BALL, *(name for name in scene.balls if name != CUE_BALL)


def others_in(scene: Scene) -> NDArray[np.float64]:
    """Places (balls, 3) [m] of all balls but the cue ball, in the order of `names_of`."""
    places = [
        (*place, scene.ball.radius) for name, place in scene.balls.items() if name != CUE_BALL
    ]
    return np.array(places, float).reshape(-1, 3)


def put_on_table(
    strokes: Strokes,
    strikes: Strikes,
    table: TableParams,
    others: NDArray[np.float64],
    tolerance: float,
    hops: float = HOPS,
) -> tuple[Strikes, TableTask]:
    """
    Put the balls onto the table as strikes leave them, and let the cues follow their strokes.

    Where other balls or cushions are near, the ball is struck again, together with them.

    Parameters
    ----------
    strokes : Strokes
    strikes : Strikes
        Of these strokes, with nothing near the ball.
    table : TableParams
    others : (balls, 3) float array
        Centres of the other balls [m].
    tolerance : float
        Of the trajectories [m].
    hops : float
        Share of the tolerance for hops that are left out.

    Returns
    -------
    strikes, task : Strikes, TableTask

    """
    model, rows = strokes.model, strikes.rows
    starts = ball_starts(len(rows), 1 + len(others))
    starts['position'][:, 0], starts['position'][:, 1:] = strokes.position, others
    starts['velocity'][:, 0], starts['spin'][:, 0] = rows['velocity'], rows['spin']
    if len(rows) and (len(others) or not is_endless(table)):
        strikes = _strike_among(strokes, strikes, table, starts)
    if not model.table:  # the ball, which may go down, is put onto the cloth
        down = starts['velocity'][:, 0, 2]
        np.maximum(down, 0.0, out=down)
    cues = following_cues(model, strikes.rows, strokes.velocities, starts['position'][:, 0])
    return strikes, TableTask(model.surface, table, starts, hops * tolerance, cues=cues)


def is_endless(table: TableParams) -> bool:
    """Whether there are no cushions."""
    return math.isinf(table.length)


def _strike_among(
    strokes: Strokes, strikes: Strikes, table: TableParams, starts: NDArray[np.void]
) -> Strikes:
    """Strike the ball together with what is near it; change strikes and starts."""
    model, rows, room = strokes.model, strikes.rows, PHASES if len(strikes.log) else 0
    places = starts['position'][0].copy()
    members, neighbours = neighbours_of(layout_of(model.surface, table), model, places)
    gaps = gaps_of(neighbours, places[members][np.newaxis], model.surface.radius)[0]
    nearest = min(
        (gap for gap, each in zip(gaps, neighbours, strict=True) if each.a == 0), default=np.inf
    )
    speeds = np.linalg.norm(strokes.velocities, axis=1)
    tried = np.flatnonzero((rows['status'] < Status.MISS) & may_reach(nearest, speeds))
    if not len(tried):
        return strikes
    some = rows[tried]
    done = strike_group(model, members, neighbours, strokes.velocities[tried], some, places, room)
    reached = tried[done.reached]
    some['together'] = True
    rows[reached], starts[reached] = some[done.reached], done.starts[done.reached]
    if room and rows['together'][-1]:
        return strikes._replace(group=done.result, met=done.met)
    return strikes


def with_strike_events(task: TableTask, strikes: Strikes, events: EventLog) -> EventLog:
    """Put the meetings of balls that are part of the last strike before the events of its run."""
    if not strikes.met:
        return events
    first: NDArray[np.void] = ROWS.records(Event, len(strikes.met))
    for row, pair in zip(first, strikes.met, strict=True):
        row['cause'], (row['ball'], row['other']) = Cause.BALL, pair
        energies = [
            kinetic_energy(task.params, start['velocity'], start['spin'])
            for start in task.starts[-1, list(pair)]
        ]
        row['energy_before'] = row['energy_after'] = sum(energies)
        row['motion_before'] = row['motion_after'] = Motion.SLIDE
    participants = events.participants + np.array([len(first), 0])
    return EventLog(np.concatenate([first, events.rows]), participants)
