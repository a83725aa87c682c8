"""Effects in the strike: a gate each, and a scene's numbers as its settings change them."""

from dataclasses import dataclass
from functools import lru_cache
import math

import numpy as np
from numpy.typing import NDArray

from billiard_shot.scene import Scene
from billiard_shot.scene.equipment import ContactParameters
from billiard_shot.shot.strike_model import strike_model, StrikeModel
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.model.cue import CLOTH_CONTACT, TIP_CONTACT
from billiard_shot.table.run.effects import (
    apply_overrides,
    EffectContext,
    gate,
    OFF,
    TABLE_GATES,
    Verdict,
)
from billiard_shot.table.run.results import moment_in_words

GUIDED = False, 'the cue is guided: its tip cannot move sideways'


@dataclass(frozen=True, slots=True)
class ShotContext(EffectContext):
    """Scene, stroke and the motion that came of them."""

    stroke: Stroke
    impulses: NDArray[np.float64]  # (2, 2) N s: of tip and table; normal and tangential
    cue_speed: float  # m/s along the stroke, at the end of the strike
    double_hit: float | None  # s, when the cue hits the ball again
    chatter: bool  # the tip touched the ball again, too soon for a second hit


@gate(
    'the strike presses the ball onto the cloth',
    'the ball is struck as if nothing were below it, and then put onto the cloth',
    off={'on_cloth': False},
)
def table_contact(shot: ShotContext) -> Verdict:
    """Look for an impulse of the cloth."""
    push = shot.impulses[CLOTH_CONTACT, 0]
    if push > 0.0:
        return True, f'the ball is pressed onto the cloth, with {push:.3g} N s'
    return False, 'the strike never presses the ball onto the cloth'


@gate(
    'the tip has friction, and would slip',
    'the tip only pushes along the normal: no English, no squirt, no massé',
    off={'friction': lambda friction: (0.0, friction[CLOTH_CONTACT])},
)
def tip_friction(shot: ShotContext) -> Verdict:
    """Look for a drag of the tip."""
    return _friction(shot, TIP_CONTACT, 'the tip', shot.scene.contacts.cue_ball)


@gate(
    'the strike presses the ball onto the cloth, and it would slip',
    'the cloth only pushes upwards while the tip is on the ball',
    off={'friction': lambda friction: (friction[TIP_CONTACT], 0.0)},
)
def table_friction(shot: ShotContext) -> Verdict:
    """Look for a drag of the cloth."""
    return _friction(shot, CLOTH_CONTACT, 'the cloth', shot.scene.contacts.ball_table)


def _friction(shot: ShotContext, contact: int, body: str, touch: ContactParameters) -> Verdict:
    push, drag = shot.impulses[contact]
    if drag > 0.0:
        return True, f'{body} drags the ball sideways with {drag:.3g} N s'
    if touch.friction == 0.0:
        return False, 'the coefficient of friction is 0'
    if push == 0.0:
        return False, f'{body} never presses on the ball'
    return False, f'there is no slip to resist at {body}'


@gate(
    'the cue is not guided',
    'the tip moves sideways freely, and swings back at once when it leaves the ball',
    off={'shaft': False},
)
def shaft(shot: ShotContext) -> Verdict:
    """Ask the scene."""
    if shot.scene.cue.guided:
        return GUIDED
    return True, 'the shaft pulls the tip back to the axis of the cue'


@gate(
    'the shaft holds a tip that has friction, and would slip',
    'no spring along the surface of the tip holds the slip at the ball',
    off={'tip_spring': False},
    # It is off by default, and would have each shot predicted twice.
    tells_without=True,
)
def tip_spring(shot: ShotContext) -> Verdict:
    """Ask the scene, and look for a drag of the tip."""
    scene = shot.scene
    if scene.cue.guided or scene.effects.shaft == OFF or scene.effects.end_mass == OFF:
        return False, 'no shaft holds the tip'
    if scene.law != 'bistiffness':
        return False, f'law {scene.law} has no time in which a tip shears'
    if shot.impulses[TIP_CONTACT, 1] > 0.0:
        return True, 'the ball drags the tip sideways, and shears it'
    return False, 'nothing shears the tip'


@gate(
    'the cue is not guided',
    'the tip cannot give way sideways, and throws the ball off line: a guided cue',
    off={'inverse_end_mass': 0.0},
)
def end_mass(shot: ShotContext) -> Verdict:
    """Ask the scene."""
    if shot.scene.cue.guided:
        return GUIDED
    mass = 1e3 * shot.scene.cue.end_mass
    return True, f'the tip can move sideways, with {mass:.3g} g of the cue'


@gate(
    'the tip is rounded, and the stroke gives the axis of the cue',
    'a rounded tip meets the ball where the axis of the cue does',
    off={'tip_curvature': 0.0},
)
def tip_curvature(shot: ShotContext) -> Verdict:
    """Compare where tip and axis meet the ball."""
    tip, radius = shot.scene.cue.tip_curvature_radius, shot.scene.ball.radius
    if tip == 0.0:
        return False, 'the tip is a point: tip_curvature_radius is 0'
    if not shot.stroke.axis:
        return False, 'the stroke says where the tip touches the ball'
    a, b, *_ = shot.stroke.offsets
    offset = radius * math.hypot(a, b)
    if offset <= 1e-12 * radius:
        return False, 'the axis of the cue goes through the middle of the ball'
    nearer = 1e3 * offset * tip / (radius + tip)
    return True, f'the tip touches the ball {nearer:.3g} mm nearer to its middle'


@gate(
    'the cue, following through, hits the ball again',
    'the cue is gone after its first hit',
    off={'follow_through': 0.0},
)
def double_hit(shot: ShotContext) -> Verdict:
    """Look for later hits of the cue."""
    if shot.double_hit is not None:
        return True, f'the cue hits the ball again {moment_in_words(shot.double_hit)}'
    if shot.chatter:
        return True, 'the tip chatters: it soon touches the ball again'
    if shot.cue_speed <= 0.0:
        return False, 'the cue does not follow through'
    return False, 'the ball stays out of the way of the cue that follows through'


_AT_ONCE = table_contact, tip_friction, table_friction, shaft, tip_spring, end_mass, tip_curvature
STRIKE_GATES = *_AT_ONCE, double_hit
GATES = *_AT_ONCE, *TABLE_GATES, double_hit
"""Of all effects, in the order of a shot."""


@lru_cache(maxsize=64)
def model_of(scene: Scene) -> StrikeModel:
    """Collect the numbers of a scene, with the effects that it forces on or off."""
    model = apply_overrides(strike_model(scene), STRIKE_GATES, scene.effects)
    return model._replace(surface=apply_overrides(model.surface, TABLE_GATES, scene.effects))
