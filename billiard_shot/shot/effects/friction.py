"""Friction in the strike: of the tip on the ball, and of the cloth under it."""

from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.shot.effects.look import ShotLook
from billiard_shot.shot.model import StrikeModel, TABLE, TIP
from billiard_shot.table.effects import Gate, OFF, Seen

N = TypeVar('N')


def _seen(friction: float, impulse: NDArray[np.float64], body: str) -> Seen:
    push, drag = impulse[0], float(np.hypot(*impulse[1:]))
    if drag > 0.0:
        return Seen(True, f'{body} drags the ball sideways with {drag:.3g} N s')
    if friction == 0.0:
        return Seen(False, 'the coefficient of friction is 0')
    if push == 0.0:
        return Seen(False, f'{body} never presses on the ball')
    return Seen(False, f'there is no slip to resist at {body}')


class _Friction(Gate[ShotLook]):
    """Without, the body only pushes along the normal."""

    contact: ClassVar[int]
    changes: ClassVar = {OFF: {}}  # one number of an array, see `force`

    def force(self, numbers: N, wish: str) -> N:
        """Smooth contact."""
        if wish == OFF and isinstance(numbers, StrikeModel):
            tip, table = numbers.friction
            friction = (0.0, table) if self.contact == TIP else (tip, 0.0)
            return numbers._replace(friction=friction)
        return numbers


class TipFriction(_Friction):
    """Without, the tip only pushes along the normal: no English, no squirt, no massé."""

    name = 'tip_friction'
    needs = 'the tip has friction, and would slip'
    contact = TIP

    def seen(self, look: ShotLook) -> Seen:
        """Off-centre strokes make the tip slip, or would."""
        return _seen(look.scene.contacts.cue_ball.friction, look.impulse(TIP), 'the tip')


class TableFriction(_Friction):
    """Without, the cloth only pushes upwards while the tip is on the ball."""

    name = 'table_friction'
    needs = 'the strike presses the ball onto the cloth, and it would slip'
    contact = TABLE

    def seen(self, look: ShotLook) -> Seen:
        """Only a ball that is pressed onto the cloth is dragged."""
        return _seen(look.scene.contacts.ball_table.friction, look.impulse(TABLE), 'the cloth')
