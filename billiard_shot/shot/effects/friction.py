"""Friction in the strike: of the tip on the ball, and of the cloth under it."""
import numpy as np
from numpy.typing import NDArray

from billiard_shot.shot.effects.effect import Gate, Look, Seen
from billiard_shot.shot.model import Model, TABLE, TIP


def _seen(friction: float, impulse: NDArray[np.float64], body: str) -> Seen:
    push, drag = impulse[0], float(np.hypot(*impulse[1:]))
    if drag > 0.0:
        return Seen(True, f'{body} drags the ball sideways with {drag:.3g} N s')
    if friction == 0.0:
        return Seen(False, 'the coefficient of friction is 0')
    if push == 0.0:
        return Seen(False, f'{body} never presses on the ball')
    return Seen(False, f'there is no slip to resist at {body}')


def _without_friction(model: Model, contact: int) -> Model:
    friction = model.friction.copy()
    friction[contact] = 0.0
    return model._replace(friction=friction)


class TipFriction(Gate):
    """Without, the tip only pushes along the normal: no English, no squirt, no massé."""

    name = 'tip_friction'
    needs = 'the tip has friction, and would slip'

    def seen(self, look: Look) -> Seen:
        """Off-centre strokes make the tip slip, or would."""
        return _seen(look.scene.contacts.cue_ball.friction, look.impulse(TIP), 'the tip')

    def off(self, model: Model) -> Model:
        """Smooth tip."""
        return _without_friction(model, TIP)


class TableFriction(Gate):
    """Without, the cloth only pushes upwards while the tip is on the ball, and in bounces."""

    name = 'table_friction'
    needs = 'the ball is pressed onto the cloth, and would slip on it'

    def seen(self, look: Look) -> Seen:
        """Only a ball that is pressed onto the cloth is dragged."""
        return _seen(look.scene.contacts.ball_table.friction, look.impulse(TABLE), 'the cloth')

    def off(self, model: Model) -> Model:
        """Smooth cloth in impacts; between them, friction is a matter of `slide`."""
        return _without_friction(model, TABLE)._replace(
            surface=model.surface._replace(friction=0.0))
