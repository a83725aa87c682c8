"""What the cloth does to the ball after the strike: sliding, rolling, and spin that decays."""
import math

from billiard_shot.shot.effects.effect import Gate, Look, Seen
from billiard_shot.shot.model import Model
from billiard_shot.table.motion import MOTION, Motion


def _does(look: Look, motion: Motion) -> bool:
    return motion in {int(code) for code in look.trajectory.rows[:, MOTION]}


class Slide(Gate):
    """Without, the ball rolls at once, as it would at the end of its slide."""

    name = 'slide'
    needs = 'the ball slips on the cloth'

    def seen(self, look: Look) -> Seen:
        """A ball that slips."""
        if _does(look, Motion.SLIDE):
            return Seen(True, 'the ball slips on the cloth')
        return Seen(False, 'the ball never slips on it')

    def off(self, model: Model) -> Model:
        """Friction that stops every slip at once."""
        return model._replace(surface=model.surface._replace(sliding=math.inf))


class Roll(Gate):
    """Without, a rolling ball meets no resistance, and never rests."""

    name = 'roll'
    needs = 'the ball comes to roll'

    def seen(self, look: Look) -> Seen:
        """A ball that rolls."""
        if _does(look, Motion.ROLL):
            return Seen(True, 'the ball comes to roll')
        return Seen(False, 'the ball never comes to roll')

    def off(self, model: Model) -> Model:
        """No resistance."""
        return model._replace(surface=model.surface._replace(rolling=0.0))


class SpinDecay(Gate):
    """Without, spin about the vertical stays, and a ball that has any never rests."""

    name = 'spin_decay'
    needs = 'the ball spins about the vertical'

    def seen(self, look: Look) -> Seen:
        """A ball that spins about the vertical, on a cloth that slows it."""
        if look.spin[2] == 0.0:
            return Seen(False, 'the ball has no spin about the vertical')
        if look.scene.cloth.spin_deceleration == 0.0:
            return Seen(False, 'the cloth does not slow spin about the vertical')
        return Seen(True, 'the ball spins about the vertical')

    def off(self, model: Model) -> Model:
        """No decay."""
        return model._replace(surface=model.surface._replace(spin_deceleration=0.0))
