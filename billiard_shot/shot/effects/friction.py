"""Friction in the strike: of the tip on the ball, and of the cloth under it."""

from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot.shot.effects.context import ShotContext
from billiard_shot.shot.strike_model import StrikeModel
from billiard_shot.table.cue_impact import CLOTH_CONTACT, TIP_CONTACT
from billiard_shot.table.effects import EffectGate, GateDecision, OFF

N = TypeVar('N')


def _seen(friction: float, impulse: NDArray[np.float64], body: str) -> GateDecision:
    push, drag = impulse
    if drag > 0.0:
        return GateDecision(True, f'{body} drags the ball sideways with {drag:.3g} N s')
    if friction == 0.0:
        return GateDecision(False, 'the coefficient of friction is 0')
    if push == 0.0:
        return GateDecision(False, f'{body} never presses on the ball')
    return GateDecision(False, f'there is no slip to resist at {body}')


class _Friction(EffectGate[ShotContext]):
    """If off, the body only pushes along the normal."""

    contact: ClassVar[int]
    overrides: ClassVar = {OFF: {}}  # one number of an array, see `force`

    def apply(self, numbers: N, setting: str) -> N:
        """Smooth contact."""
        if setting == OFF and isinstance(numbers, StrikeModel):
            tip, cloth = numbers.friction
            friction = (0.0, cloth) if self.contact == TIP_CONTACT else (tip, 0.0)
            return numbers._replace(friction=friction)
        return numbers


class TipFriction(_Friction):
    """If off, the tip only pushes along the normal: no English, no squirt, no massé."""

    name = 'tip_friction'
    condition = 'the tip has friction, and would slip'
    contact = TIP_CONTACT

    def evaluate(self, context: ShotContext) -> GateDecision:
        """Off-centre strokes make the tip slip, or would."""
        return _seen(
            context.scene.contacts.cue_ball.friction, context.impulse(TIP_CONTACT), 'the tip'
        )


class TableFriction(_Friction):
    """If off, the cloth only pushes upwards while the tip is on the ball."""

    name = 'table_friction'
    condition = 'the strike presses the ball onto the cloth, and it would slip'
    contact = CLOTH_CONTACT

    def evaluate(self, context: ShotContext) -> GateDecision:
        """Only a ball that is pressed onto the cloth is dragged."""
        return _seen(
            context.scene.contacts.ball_table.friction, context.impulse(CLOTH_CONTACT), 'the cloth'
        )
