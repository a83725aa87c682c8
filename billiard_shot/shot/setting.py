"""A scene as compiled code takes it, made once."""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.records import OBJECTS, Triple
from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.strike_model import cue_params, StrikeModel
from billiard_shot.table.clearance import nothing_around, Surroundings, surroundings_of
from billiard_shot.table.cue import CueParams
from billiard_shot.table.cue_placement import reaching_speed
from billiard_shot.table.effects import table_on
from billiard_shot.table.geometry import lay_out, table_of
from billiard_shot.table.initial_states import ball_starts, BallStart
from billiard_shot.table.params import TableParams
from billiard_shot.table.scene_params import ENDLESS


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
    reaching : float
        See `reaching_speed`.

    """

    model: StrikeModel
    table: TableParams
    around: Surroundings
    cue: CueParams
    names: tuple[str, ...]
    starts: NDArray[np.void]
    reaching: float


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
    around = nothing_around(model.ferrule_radius, model.surface.radius)
    return _setting(model, ENDLESS, around, (CUE_BALL,), places)


def _setting(
    model: StrikeModel,
    table: TableParams,
    around: Surroundings,
    names: tuple[str, ...],
    places: Sequence[Triple],
) -> Setting:
    starts = ball_starts(1, len(names))
    starts['position'] = places
    cue = cue_params(model, table)
    laid_out = table_of(lay_out(OBJECTS, model.surface, table, cue=cue))
    balls = OBJECTS.from_rows(BallStart, starts[0])
    reaching = reaching_speed(laid_out, balls, 0, len(balls))
    return Setting(model, table, around, cue, names, starts, reaching)
