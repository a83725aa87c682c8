"""Of the strike: the table below the ball, the end and tip of the cue, and where it follows."""

import math
from typing import ClassVar

from billiard_shot.shot.effects.look import ShotLook
from billiard_shot.shot.model import TABLE
from billiard_shot.table.effects import Gate, OFF, Seen


class TableContact(Gate[ShotLook]):
    """Without, the ball is struck as if nothing were below it, and then put onto the cloth."""

    name = 'table_contact'
    needs = 'the strike presses the ball onto the cloth'
    changes: ClassVar = {OFF: {'table': False}}

    def seen(self, look: ShotLook) -> Seen:
        """See whether the impact closes the contact, or leaves it open."""
        push = look.impulse(TABLE)[0]
        if push > 0.0:
            return Seen(True, f'the ball is pressed onto the cloth, with {push:.3g} N s')
        return Seen(False, 'the strike never presses the ball onto the cloth')


class EndMass(Gate[ShotLook]):
    """Without, the tip cannot give way sideways, and throws the ball off line: a guided cue."""

    name = 'end_mass'
    needs = 'the cue is not guided'
    changes: ClassVar = {OFF: {'inverse_end_mass': 0.0}}

    def seen(self, look: ShotLook) -> Seen:
        """Ask the cue."""
        cue = look.scene.cue
        if cue.guided:
            return Seen(False, 'the cue is guided: its tip cannot move sideways')
        return Seen(True, f'the tip can move sideways, with {1e3 * cue.end_mass:.3g} g of the cue')


class TipCurvature(Gate[ShotLook]):
    """Without, a rounded tip meets the ball where the axis of the cue does."""

    name = 'tip_curvature'
    needs = 'the tip is rounded, and the stroke says where the axis of the cue goes'
    changes: ClassVar = {OFF: {'tip_curvature': 0.0}}

    def seen(self, look: ShotLook) -> Seen:
        """Ask the cue and the stroke."""
        dome, radius = look.scene.cue.dome, look.scene.ball.radius
        if dome == 0.0:
            return Seen(False, 'the tip is a point: the cue has no dome')
        if not look.stroke.axis:
            return Seen(False, 'the stroke says where the tip touches the ball')
        a, b, *_ = look.stroke.offsets
        offset = radius * math.hypot(a, b)
        if offset <= 1e-12 * radius:
            return Seen(False, 'the axis of the cue goes through the middle of the ball')
        nearer = 1e3 * offset * dome / (radius + dome)
        return Seen(True, f'the tip touches the ball {nearer:.3g} mm nearer to its middle')


class DoubleHit(Gate[ShotLook]):
    """Without, nobody looks whether the cue, following through, catches the ball again."""

    name = 'double_hit'
    needs = 'the cue, following through, catches the ball again'
    changes: ClassVar = {}  # it is found afterwards, in the motion

    def seen(self, look: ShotLook) -> Seen:
        """See how the ball moves, and how fast the cue follows."""
        if look.double_hit is not None:
            return Seen(True, f'the cue has the ball again at {look.double_hit:.3g} s')
        if look.cue_speed <= 0.0:
            return Seen(False, 'the cue does not follow through')
        return Seen(False, 'the ball stays out of the way of the cue that follows through')
