"""A scene as compiled code takes it, made once."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.shot.clearance import NOTHING_AROUND, Surroundings, surroundings_of
from billiard_shot.shot.effects import model_of
from billiard_shot.shot.model import cue_params, StrikeModel
from billiard_shot.table.cue import CueParams
from billiard_shot.table.effects import table_on
from billiard_shot.table.initial_states import ball_starts
from billiard_shot.table.model import ENDLESS
from billiard_shot.table.params import TableParams


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
    names : tuple of str
        The balls; the cue ball first, others in the scene's order.
    starts : (1, balls) array of BallStart
        The balls at rest. Not to be changed.

    """

    model: StrikeModel
    table: TableParams
    around: Surroundings
    names: tuple[str, ...]
    starts: NDArray[np.void]

    @property
    def cue(self) -> CueParams:
        """What impacts with the cue depend on."""
        return cue_params(self.model, self.table)


@lru_cache(maxsize=64)
def setting_of(scene: Scene) -> Setting:
    """Collect what a scene means to compiled code, with the effects that it forces on or off."""
    names = (CUE_BALL, *(name for name in scene.balls if name != CUE_BALL))
    starts = ball_starts(1, len(names))
    starts['position'][0, 0] = scene.cue_ball
    for place, name in zip(starts['position'][0, 1:], names[1:], strict=True):
        place[:] = (*scene.balls[name], scene.ball.radius)
    return Setting(model_of(scene), table_on(scene), surroundings_of(scene), names, starts)


def alone(model: StrikeModel) -> Setting:
    """Make the setting of a cue ball alone on endless cloth, at the origin."""
    starts = ball_starts(1, 1)
    starts['position'][..., 2] = model.surface.radius
    return Setting(model, ENDLESS, NOTHING_AROUND, (CUE_BALL,), starts)
