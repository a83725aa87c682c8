"""What follows a strike where there is more than a ball on an endless cloth: the whole table."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact import CollisionResult
from billiard_shot.numerics import rounding
from billiard_shot.records import ROWS
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, no_place
from billiard_shot.shot.contact_geometry import gaps_of
from billiard_shot.shot.group_strike import may_reach, strike_group
from billiard_shot.shot.model import StrikeModel
from billiard_shot.shot.neighbours import neighbours_of
from billiard_shot.status import Status
from billiard_shot.table.geometry import layout_of
from billiard_shot.table.initial_states import ball_starts
from billiard_shot.table.motion import Cause, Motion
from billiard_shot.table.params import BallClothParams, TableParams
from billiard_shot.table.run import EventLog, TableRun
from billiard_shot.table.simulation_state import Event, kinetic_energy


def has_table(scene: Scene) -> bool:
    """Whether a struck ball can meet anything but the cloth."""
    return scene.table is not None or bool(set(scene.balls) - {CUE_BALL})


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


def starts_after(
    scene: Scene, centre: NDArray[np.float64], strikes: NDArray[np.void]
) -> NDArray[np.void]:
    """Return (strikes, balls) BallStart: the cue ball as struck, all others at rest."""
    names = names_of(scene)
    starts = ball_starts(len(strikes), len(names))
    position = starts['position']
    position[:, 0] = centre
    for i, name in enumerate(names[1:], 1):
        position[:, i] = *scene.balls[name], scene.ball.radius
    starts['velocity'][:, 0], starts['spin'][:, 0] = strikes['velocity'], strikes['spin']
    return starts


class Struck(NamedTuple):
    """What n strikes leave on the table."""

    starts: NDArray[np.void]  # (n, balls) BallStart
    together: NDArray[np.bool_]  # (n,) whether the ball reached a neighbour during the strike
    # Of the last strike, if that is so and phases were asked for: in detail; balls that met.
    group: CollisionResult | None
    met: list[tuple[int, int]]


def strike_among(
    scene: Scene,
    model: StrikeModel,
    table: TableParams,
    centre: NDArray[np.float64],
    velocities: NDArray[np.float64],
    strikes: NDArray[np.void],
    phases: int = 0,
) -> Struck:
    """
    Find the states after strikes on endless cloth; if other balls or cushions are near, with them.

    Parameters
    ----------
    scene, model, table : Scene, StrikeModel, TableParams
    centre : (3,) float array
        Of the ball that is struck [m].
    velocities : (n, 3) float array
        Of the cue [m/s].
    strikes : (n,) Strike, changed
    phases : int
        If above 0, the impact of the last strike is returned in detail.

    """
    starts = starts_after(scene, centre, strikes)
    places = starts['position'][0] if len(starts) else np.zeros((1, 3))
    members, neighbours = neighbours_of(layout_of(model.surface, table), model, places)
    played = strikes['status'] < Status.MISS
    gaps = gaps_of(neighbours, places[np.newaxis, members], model.surface.radius)[0]
    nearest = min(
        (gap for gap, each in zip(gaps, neighbours, strict=True) if each.a == 0), default=np.inf
    )
    played &= may_reach(nearest, np.linalg.norm(velocities, axis=1))
    if not played.any():
        return Struck(starts, played, None, [])
    some = strikes[played]
    done = strike_group(model, members, neighbours, velocities[played], some, places, phases)
    played[played] = done.reached
    strikes[played], starts[played] = some[done.reached], done.starts[done.reached]
    if not played[-1]:
        return Struck(starts, played, None, [])
    return Struck(starts, played, done.result, done.met)


def with_first_events(run: TableRun, struck: Struck, params: BallClothParams) -> TableRun:
    """Put the impacts between balls that are part of the strike before the events of a run."""
    first: NDArray[np.void] = ROWS.records(Event, len(struck.met))
    for row, pair in zip(first, struck.met, strict=True):
        row['cause'], (row['ball'], row['other']) = Cause.BALL, pair
        energies = [
            kinetic_energy(params, start['velocity'], start['spin'])
            for start in struck.starts[-1, list(pair)]
        ]
        row['energy_before'] = row['energy_after'] = sum(energies)
        row['motion_before'] = row['motion_after'] = Motion.SLIDE
    log = run._events
    participants = log.participants + np.array([len(first), 0])
    events = EventLog(np.concatenate([first, log.rows]), participants)
    return replace(run, _events=events)
