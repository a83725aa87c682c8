"""What the cloth does to a ball: sliding, rolling, and spin that decays."""

from collections.abc import Sequence
import math
from typing import ClassVar

import numpy as np

from billiard_shot.table.effects.effect import EffectContext, EffectGate, GateDecision, OFF
from billiard_shot.table.motion import Motion


class Slide(EffectGate[EffectContext]):
    """If off, a ball rolls at once, as it would at the end of its slide."""

    name = 'slide'
    condition = 'a ball slips on the cloth'
    overrides: ClassVar = {OFF: {'sliding_friction': math.inf}}

    def evaluate(self, context: EffectContext) -> GateDecision:
        """EffectContext for a ball that slips."""
        return _seen(context.that_do(Motion.SLIDE), 'slip on the cloth')


class Roll(EffectGate[EffectContext]):
    """If off, a rolling ball meets no resistance, and never rests."""

    name = 'roll'
    condition = 'a ball comes to roll'
    overrides: ClassVar = {OFF: {'rolling_resistance': 0.0, 'rolling_rise': 0.0}}

    def evaluate(self, context: EffectContext) -> GateDecision:
        """EffectContext for a ball that rolls."""
        return _seen(context.that_do(Motion.ROLL), 'come to roll')


class SpinDecay(EffectGate[EffectContext]):
    """If off, spin about the vertical stays, and a ball that has any never rests."""

    name = 'spin_decay'
    condition = 'a ball spins about the vertical'
    overrides: ClassVar = {OFF: {'spin_deceleration': 0.0}}

    def evaluate(self, context: EffectContext) -> GateDecision:
        """EffectContext for a ball that spins about the vertical, on a cloth that slows it."""
        turning = [
            name for name, ball in context.run.balls.items() if np.any(ball.rows['spin'][:, 2])
        ]
        if turning and context.scene.cloth.spin_deceleration == 0.0:
            return GateDecision(False, 'the cloth does not slow spin about the vertical')
        return _seen(turning, 'spin about the vertical')


def _seen(names: Sequence[str], what: str) -> GateDecision:
    """Say which balls do something, or that none does."""
    return (
        GateDecision(True, f'balls that {what}: {", ".join(names)}')
        if names
        else GateDecision(False, f'no ball that would {what}')
    )
