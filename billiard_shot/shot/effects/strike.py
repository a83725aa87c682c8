"""Of the strike: the table below the ball, the end and tip of the cue, and where it follows."""

import math
from typing import ClassVar

from billiard_shot.shot.effects.context import ShotContext
from billiard_shot.table.cue_impact import CLOTH_CONTACT, TIP_CONTACT
from billiard_shot.table.effects import EffectGate, GateDecision, OFF
from billiard_shot.table.words import moment_in_words


class TableContact(EffectGate[ShotContext]):
    """If off, the ball is struck as if nothing were below it, and then put onto the cloth."""

    name = 'table_contact'
    condition = 'the strike presses the ball onto the cloth'
    overrides: ClassVar = {OFF: {'on_cloth': False}}

    def evaluate(self, context: ShotContext) -> GateDecision:
        """See whether the impact closes the contact, or leaves it open."""
        push = context.impulse(CLOTH_CONTACT)[0]
        if push > 0.0:
            return GateDecision(True, f'the ball is pressed onto the cloth, with {push:.3g} N s')
        return GateDecision(False, 'the strike never presses the ball onto the cloth')


class EndMass(EffectGate[ShotContext]):
    """If off, the tip cannot give way sideways, and throws the ball off line: a guided cue."""

    name = 'end_mass'
    condition = 'the cue is not guided'
    overrides: ClassVar = {OFF: {'inverse_end_mass': 0.0}}

    def evaluate(self, context: ShotContext) -> GateDecision:
        """Ask the cue."""
        cue = context.scene.cue
        if cue.guided:
            return GateDecision(False, 'the cue is guided: its tip cannot move sideways')
        return GateDecision(
            True, f'the tip can move sideways, with {1e3 * cue.end_mass:.3g} g of the cue'
        )


class Shaft(EffectGate[ShotContext]):
    """If off, the tip moves sideways freely, and swings back at once when it leaves the ball."""

    name = 'shaft'
    condition = 'the cue is not guided'
    overrides: ClassVar = {OFF: {'shaft': False}}

    def evaluate(self, context: ShotContext) -> GateDecision:
        """Ask the cue."""
        if context.scene.cue.guided:
            return GateDecision(False, 'the cue is guided: its tip cannot move sideways')
        return GateDecision(True, 'the shaft pulls the tip back to the axis of the cue')


class TipSpring(EffectGate[ShotContext]):
    """If not off, the tip shears: a spring along its surface holds the slip at the ball."""

    name = 'tip_spring'
    condition = 'the shaft holds a tip that has friction, and would slip'
    overrides: ClassVar = {OFF: {'tip_spring': False}}
    tells_without = True  # it is off by default, and would have each shot predicted twice

    def evaluate(self, context: ShotContext) -> GateDecision:
        """Ask cue and law, and see whether the tip is dragged sideways."""
        scene = context.scene
        if scene.cue.guided or scene.effects.shaft == OFF or scene.effects.end_mass == OFF:
            return GateDecision(False, 'no shaft holds the tip')
        if scene.law != 'bistiffness':
            return GateDecision(False, f'law {scene.law} has no time in which a tip shears')
        if context.impulse(TIP_CONTACT)[1] > 0.0:
            return GateDecision(True, 'the ball drags the tip sideways, and shears it')
        return GateDecision(False, 'nothing shears the tip')


class TipCurvature(EffectGate[ShotContext]):
    """If off, a rounded tip meets the ball where the axis of the cue does."""

    name = 'tip_curvature'
    condition = 'the tip is rounded, and the stroke gives the axis of the cue'
    overrides: ClassVar = {OFF: {'tip_curvature': 0.0}}

    def evaluate(self, context: ShotContext) -> GateDecision:
        """Ask the cue and the stroke."""
        tip, radius = context.scene.cue.tip_curvature_radius, context.scene.ball.radius
        if tip == 0.0:
            return GateDecision(False, 'the tip is a point: tip_curvature_radius is 0')
        if not context.stroke.axis:
            return GateDecision(False, 'the stroke says where the tip touches the ball')
        a, b, *_ = context.stroke.offsets
        offset = radius * math.hypot(a, b)
        if offset <= 1e-12 * radius:
            return GateDecision(False, 'the axis of the cue goes through the middle of the ball')
        nearer = 1e3 * offset * tip / (radius + tip)
        return GateDecision(True, f'the tip touches the ball {nearer:.3g} mm nearer to its middle')


class DoubleHit(EffectGate[ShotContext]):
    """If off, the cue is gone after its first hit."""

    name = 'double_hit'
    condition = 'the cue, following through, hits the ball again'
    overrides: ClassVar = {OFF: {'follow_through': 0.0}}

    def evaluate(self, context: ShotContext) -> GateDecision:
        """See how the ball moves, and how fast the cue follows."""
        if context.double_hit is not None:
            when = moment_in_words(context.double_hit)
            return GateDecision(True, f'the cue hits the ball again {when}')
        if context.chatter:
            return GateDecision(True, 'the tip chatters: it soon touches the ball again')
        if context.cue_speed <= 0.0:
            return GateDecision(False, 'the cue does not follow through')
        return GateDecision(False, 'the ball stays out of the way of the cue that follows through')
