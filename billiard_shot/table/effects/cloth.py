"""What the cloth does to a ball: sliding, rolling, and spin that decays."""

from collections.abc import Sequence
import math
from typing import ClassVar

import numpy as np

from billiard_shot.table.effects.effect import Gate, Look, OFF, Seen
from billiard_shot.table.motion import Motion


class Slide(Gate[Look]):
    """Without, a ball rolls at once, as it would at the end of its slide."""

    name = 'slide'
    needs = 'a ball slips on the cloth'
    changes: ClassVar = {OFF: {'sliding_friction': math.inf}}

    def seen(self, look: Look) -> Seen:
        """Look for a ball that slips."""
        return _seen(look, look.that_do(Motion.SLIDE), 'slip on the cloth')


class Roll(Gate[Look]):
    """Without, a rolling ball meets no resistance, and never rests."""

    name = 'roll'
    needs = 'a ball comes to roll'
    changes: ClassVar = {OFF: {'rolling_resistance': 0.0}}

    def seen(self, look: Look) -> Seen:
        """Look for a ball that rolls."""
        return _seen(look, look.that_do(Motion.ROLL), 'come to roll')


class SpinDecay(Gate[Look]):
    """Without, spin about the vertical stays, and a ball that has any never rests."""

    name = 'spin_decay'
    needs = 'a ball spins about the vertical'
    changes: ClassVar = {OFF: {'spin_deceleration': 0.0}}

    def seen(self, look: Look) -> Seen:
        """Look for a ball that spins about the vertical, on a cloth that slows it."""
        turning = [
            name for name, ball in look.trajectories.items() if np.any(ball.rows['spin'][:, 2])
        ]
        if turning and look.scene.cloth.spin_deceleration == 0.0:
            return Seen(False, 'the cloth does not slow spin about the vertical')
        return _seen(look, turning, 'spin about the vertical')


def _seen(look: Look, names: Sequence[str], what: str) -> Seen:
    """Say which balls do something, or that none does."""
    return (
        Seen(True, f'balls that {what}: {", ".join(names)}')
        if names
        else Seen(False, f'no ball that would {what}')
    )
