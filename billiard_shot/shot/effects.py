"""Effects in the strike: a row for each, and a scene's numbers as its settings change them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.shot.strike_model import strike_model, StrikeModel
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.model.cue import CLOTH_CONTACT, TIP_CONTACT
from billiard_shot.table.run.effects import (
    apply_overrides,
    check_overrides,
    EffectContext,
    EffectGate,
    GateDecision,
    OFF,
    TABLE_GATES,
)
from billiard_shot.table.run.results import moment_in_words


@dataclass(frozen=True, slots=True)
class ShotContext(EffectContext):
    """Scene, stroke and the motion that came of them."""

    stroke: Stroke
    impulses: NDArray[np.float64]  # (2, 2) N s: of tip and table; normal and tangential
    cue_speed: float  # m/s along the stroke, at the end of the strike
    double_hit: float | None  # s, when the cue hits the ball again
    chatter: bool  # the tip touched the ball again, too soon for a second hit


def _table_contact(context: ShotContext) -> GateDecision:
    push = context.impulses[CLOTH_CONTACT, 0]
    if push > 0.0:
        return GateDecision(True, f'the ball is pressed onto the cloth, with {push:.3g} N s')
    return GateDecision(False, 'the strike never presses the ball onto the cloth')


def _friction_at(contact: int) -> Callable[[ShotContext], GateDecision]:
    body = 'the tip' if contact == TIP_CONTACT else 'the cloth'

    def evaluate(context: ShotContext) -> GateDecision:
        contacts = context.scene.contacts
        touch = contacts.cue_ball if contact == TIP_CONTACT else contacts.ball_table
        push, drag = context.impulses[contact]
        if drag > 0.0:
            return GateDecision(True, f'{body} drags the ball sideways with {drag:.3g} N s')
        if touch.friction == 0.0:
            return GateDecision(False, 'the coefficient of friction is 0')
        if push == 0.0:
            return GateDecision(False, f'{body} never presses on the ball')
        return GateDecision(False, f'there is no slip to resist at {body}')

    return evaluate


def _shaft(context: ShotContext) -> GateDecision:
    if context.scene.cue.guided:
        return GateDecision(False, 'the cue is guided: its tip cannot move sideways')
    return GateDecision(True, 'the shaft pulls the tip back to the axis of the cue')


def _tip_spring(context: ShotContext) -> GateDecision:
    scene = context.scene
    if scene.cue.guided or scene.effects.shaft == OFF or scene.effects.end_mass == OFF:
        return GateDecision(False, 'no shaft holds the tip')
    if scene.law != 'bistiffness':
        return GateDecision(False, f'law {scene.law} has no time in which a tip shears')
    if context.impulses[TIP_CONTACT, 1] > 0.0:
        return GateDecision(True, 'the ball drags the tip sideways, and shears it')
    return GateDecision(False, 'nothing shears the tip')


def _end_mass(context: ShotContext) -> GateDecision:
    cue = context.scene.cue
    if cue.guided:
        return GateDecision(False, 'the cue is guided: its tip cannot move sideways')
    return GateDecision(
        True, f'the tip can move sideways, with {1e3 * cue.end_mass:.3g} g of the cue'
    )


def _tip_curvature(context: ShotContext) -> GateDecision:
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


def _double_hit(context: ShotContext) -> GateDecision:
    if context.double_hit is not None:
        when = moment_in_words(context.double_hit)
        return GateDecision(True, f'the cue hits the ball again {when}')
    if context.chatter:
        return GateDecision(True, 'the tip chatters: it soon touches the ball again')
    if context.cue_speed <= 0.0:
        return GateDecision(False, 'the cue does not follow through')
    return GateDecision(False, 'the ball stays out of the way of the cue that follows through')


STRIKE_GATES: tuple[EffectGate[ShotContext], ...] = (
    EffectGate(
        'table_contact',
        'the strike presses the ball onto the cloth',
        'the ball is struck as if nothing were below it, and then put onto the cloth',
        _table_contact,
        off={'on_cloth': False},
    ),
    EffectGate(
        'tip_friction',
        'the tip has friction, and would slip',
        'the tip only pushes along the normal: no English, no squirt, no massé',
        _friction_at(TIP_CONTACT),
        off={'friction': lambda friction: (0.0, friction[CLOTH_CONTACT])},
    ),
    EffectGate(
        'table_friction',
        'the strike presses the ball onto the cloth, and it would slip',
        'the cloth only pushes upwards while the tip is on the ball',
        _friction_at(CLOTH_CONTACT),
        off={'friction': lambda friction: (friction[TIP_CONTACT], 0.0)},
    ),
    EffectGate(
        'shaft',
        'the cue is not guided',
        'the tip moves sideways freely, and swings back at once when it leaves the ball',
        _shaft,
        off={'shaft': False},
    ),
    EffectGate(
        'tip_spring',
        'the shaft holds a tip that has friction, and would slip',
        'no spring along the surface of the tip holds the slip at the ball',
        _tip_spring,
        off={'tip_spring': False},
        # It is off by default, and would have each shot predicted twice.
        tells_without=True,
    ),
    EffectGate(
        'end_mass',
        'the cue is not guided',
        'the tip cannot give way sideways, and throws the ball off line: a guided cue',
        _end_mass,
        off={'inverse_end_mass': 0.0},
    ),
    EffectGate(
        'tip_curvature',
        'the tip is rounded, and the stroke gives the axis of the cue',
        'a rounded tip meets the ball where the axis of the cue does',
        _tip_curvature,
        off={'tip_curvature': 0.0},
    ),
    EffectGate(
        'double_hit',
        'the cue, following through, hits the ball again',
        'the cue is gone after its first hit',
        _double_hit,
        off={'follow_through': 0.0},
    ),
)
check_overrides(STRIKE_GATES, StrikeModel)
GATES: tuple[EffectGate[Any], ...] = (*STRIKE_GATES[:-1], *TABLE_GATES, STRIKE_GATES[-1])


@lru_cache(maxsize=64)
def model_of(scene: Scene) -> StrikeModel:
    """Collect the numbers of a scene, with the effects that it forces on or off."""
    model = apply_overrides(strike_model(scene), STRIKE_GATES, scene.effects)
    return model._replace(surface=apply_overrides(model.surface, TABLE_GATES, scene.effects))
