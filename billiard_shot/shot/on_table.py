"""Strokes on the table: where all balls and the cues are as their runs begin."""

import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL, no_place
from billiard_shot.shot.accuracy import HOPS
from billiard_shot.shot.clearance import surroundings_of
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.model import cue_params, StrikeModel
from billiard_shot.shot.strike import cues_of, Strokes
from billiard_shot.table.cue import TIP_DURATION
from billiard_shot.table.effects import table_on
from billiard_shot.table.initial_states import ball_starts
from billiard_shot.table.params import GATE_OFF, TableParams
from billiard_shot.table.simulate import BatchRecording, run_tables, TableTask

FARTHEST = 2.0  # way of a ball while a tip touches it, in lengths that the cue alone would go


def check_place(scene: Scene, centre: Array) -> None:
    """Raise ValueError if the cue ball cannot be there, because another one is, or a cushion."""
    x, y = float(centre[0]), float(centre[1])
    others = {name: place for name, place in scene.balls.items() if name != CUE_BALL}
    if why := no_place(scene.table, x, y, scene.ball.radius, others):
        raise ValueError(f'position must be {why}, got ({x:g}, {y:g}) (m)')


def names_of(scene: Scene) -> tuple[str, ...]:
    """Names of all balls: the cue ball, and the others in the scene's order."""
    return CUE_BALL, *(name for name in scene.balls if name != CUE_BALL)


def others_in(scene: Scene) -> Array:
    """Places (balls, 3) [m] of all balls but the cue ball, in the order of `names_of`."""
    places = [
        (*place, scene.ball.radius) for name, place in scene.balls.items() if name != CUE_BALL
    ]
    return np.array(places, float).reshape(-1, 3)


def reaching_speed(
    model: StrikeModel,
    table: TableParams,
    place: Array,
    others: Array,
) -> float:
    """
    Find the speed of the cue [m/s] from which on a ball may reach others, or noses, in a strike.

    Parameters
    ----------
    model : StrikeModel
    table : TableParams
    place : (3,) float array
        Centre of the ball [m].
    others : (balls, 3) float array
        Centres of the other balls [m].

    """
    radius = model.surface.radius
    nearest = math.inf
    if len(others) and table.pair_gate != GATE_OFF:
        nearest = float(np.linalg.norm(others - place, axis=1).min()) - 2.0 * radius
    x, y, z = place.tolist()
    away = min(0.5 * table.length - abs(x), 0.5 * table.width - abs(y))
    if away < math.inf:
        nearest = min(nearest, math.hypot(away, z - table.nose_height) - radius)
    reach = cue_params(model, table).neighbour_reach
    return nearest / (FARTHEST * TIP_DURATION) if nearest <= reach else math.inf


def strokes_in(scene: Scene, normals: Array, velocities: Array, position: Array) -> Strokes:
    """State strokes at the cue ball of a scene, which lies at a position; see `Strokes`."""
    return Strokes(
        model_of(scene),
        normals,
        velocities,
        position,
        surroundings_of(scene),
        table=table_on(scene),
        others=others_in(scene),
    )


def table_task(strokes: Strokes, tolerance: float, hops: float = HOPS) -> TableTask:
    """
    State the tables on which strokes are played; a refused stroke leaves the ball where it is.

    Parameters
    ----------
    strokes : Strokes
    tolerance : float
        Of the trajectories [m].
    hops : float
        Share of the tolerance for hops that are left out.

    """
    model, _, _, place, _, table, others = strokes
    return TableTask(
        model.surface,
        table,
        starts_of(place, others, len(strokes.normals)),
        hops * tolerance,
        cue=cue_params(model, table),
        cues=cues_of(strokes, tolerance, reaching_speed(model, table, place, others)),
    )


def starts_of(place: Array, others: Array, tables: int) -> NDArray[np.void]:
    """Make (tables, balls) BallStart: the struck ball at a place (3,), and others (balls, 3)."""
    starts = ball_starts(tables, 1 + len(others))
    starts['position'][:, 0], starts['position'][:, 1:] = place, others
    return starts


def strike_batch(strokes: Strokes, tolerance: float) -> BatchRecording:
    """Simulate only the strikes of strokes, after which balls begin; see `table_task`."""
    return run_tables(table_task(strokes, tolerance)._replace(until=0.0))
