"""A scene as compiled code takes it, made once."""

from collections.abc import Sequence
from functools import lru_cache
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import Array, Triple
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.clearance import NOTHING_AROUND, Surroundings, surroundings_of
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.strike_model import cue_params, StrikeModel
from billiard_shot.table.cue import CueParams, TIP_DURATION
from billiard_shot.table.effects import table_on
from billiard_shot.table.initial_states import ball_starts
from billiard_shot.table.params import GATE_OFF, TableParams
from billiard_shot.table.scene_params import ENDLESS

FARTHEST = 2.0  # way of a ball while a tip touches it, in lengths that the cue alone would go


class Setting(NamedTuple):
    """
    All that strokes depend on, beside themselves.

    Attributes
    ----------
    model : StrikeModel
        Ball, cue and cloth.
    table : TableParams
    around : Surroundings
        What a cue may have no room for: such a stroke is refused.
    cue : CueParams
        What impacts with the cue depend on.
    names : tuple of str
        The balls; the cue ball first, others in the scene's order.
    starts : (1, balls) array of BallStart
        The balls at rest. Not to be changed.
    reaching : (1,) float array
        See `reaching_speeds`.

    """

    model: StrikeModel
    table: TableParams
    around: Surroundings
    cue: CueParams
    names: tuple[str, ...]
    starts: NDArray[np.void]
    reaching: Array


@lru_cache(maxsize=64)
def setting_of(scene: Scene) -> Setting:
    """Collect what a scene means to compiled code, with the effects that it forces on or off."""
    names = (CUE_BALL, *scene.object_balls)
    radius = scene.ball.radius
    places = [scene.cue_ball, *((*scene.balls[name], radius) for name in names[1:])]
    return _setting(model_of(scene), table_on(scene), surroundings_of(scene), names, places)


@lru_cache(maxsize=64)
def alone(model: StrikeModel) -> Setting:
    """Make the setting of a cue ball alone on endless cloth, at the origin."""
    places = [(0.0, 0.0, model.surface.radius)]
    return _setting(model, ENDLESS, NOTHING_AROUND, (CUE_BALL,), places)


def _setting(
    model: StrikeModel,
    table: TableParams,
    around: Surroundings,
    names: tuple[str, ...],
    places: Sequence[Triple],
) -> Setting:
    starts = ball_starts(1, len(names))
    starts['position'] = places
    reaching = reaching_speeds(model, table, starts['position'])
    return Setting(model, table, around, cue_params(model, table), names, starts, reaching)


def reaching_speeds(model: StrikeModel, table: TableParams, places: Array) -> Array:
    """
    Find speeds of the cue from which on a ball may reach others, or noses, in a strike.

    Parameters
    ----------
    model : StrikeModel
    table : TableParams
    places : (tables, balls, 3) float array
        Centres of the balls, the struck one first [m]; NaN: the table does not have it.

    Returns
    -------
    (tables,) float array
        [m/s]; infinite if no others are near.

    """
    radius = model.surface.radius
    x, y, z = places[:, 0].T
    away = np.minimum(0.5 * table.length - np.abs(x), 0.5 * table.width - np.abs(y))
    nearest = np.hypot(away, z - table.nose_height) - radius
    if table.pair_gate != GATE_OFF:
        others = np.linalg.norm(places[:, 1:] - places[:, :1], axis=2) - 2.0 * radius
        nearest = np.fmin(nearest, np.fmin.reduce(others, axis=1, initial=inf))
    near = nearest <= cue_params(model, table).neighbour_reach
    return np.where(near, nearest / (FARTHEST * TIP_DURATION), inf)
