"""
The numbers of a scene that a strike depends on, and its effects: a gate each.

Settings of effects change the numbers. Compiled code takes them as a `StrikeModel`.
"""

from dataclasses import dataclass
from functools import lru_cache
import math
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.compiled import inner
from billiard_shot.impact.options import BISTIFFNESS, LAWS
from billiard_shot.scene import Scene
from billiard_shot.scene.equipment import ContactParameters
from billiard_shot.shot.stroke import Stroke
from billiard_shot.table.model.cue import CLOTH_CONTACT, CueParams, TIP_CONTACT
from billiard_shot.table.model.geometry import (
    BallClothParams,
    stiffness_of,
    STROKE_SPEED,
    TableParams,
)
from billiard_shot.table.run.effects import (
    apply_overrides,
    EffectContext,
    gate,
    OFF,
    TABLE_GATES,
    Verdict,
)
from billiard_shot.table.run.layout import ball_cloth_params
from billiard_shot.table.run.results import moment_in_words

REACH = 0.03  # m: farther than a ball goes while the tip of a cue at 10 m/s touches it
NORMALS = 16  # that a contact has while the tip touches the ball
# The bending shaft as an end with a dashpot: its mass relative to the effective mass of the cue's
# end, and the rate [1/s] at which it loses its motion, per that mass. 4 to 5 kg/s for 4.2 g are
# near the waves on a maple shaft 13 mm thick. A tip that does not shear needs a lighter end, whose
# mass is fitted in scene `pool`, where the tip has the restitution 0.75: squirt at 0.1, 0.3 and
# 0.5 radii is 0.45, 1.25 and 1.99 degrees at 2 m/s.
SHAFT_MASS, SHAFT_DAMPING = 0.58, 950.0
# With the effect `tip_spring` and the exponent 1.5: 0.41, 1.17 and, at 0.48 radii, 1.85 degrees.
# So strikes agree with those of a chain of masses for that shaft and its ferrule.
SOFT_TIP_SHAFT_MASS, SOFT_TIP_SHAFT_DAMPING = 1.0, 1190.0
# Stiffness of a tip along its surface relative to that along the normal. Films show that contacts
# off centre last longer (docs/limits.md), which needs at most 0.5.
TIP_SHEAR = 0.48
# Of tip and ball at DURATION_SPEED [s], if the scene has only a ratio of stiffnesses: high-speed
# films, Alciatore (billiards.colostate.edu).
TIP_DURATION = 1.3e-3
# Of a tip with a duration, in the unit of the stiffnesses of balls and cushions; as in the paper.
TIP_STIFFNESS = 1.5


class StrikeModel(NamedTuple):
    """The numbers of a scene on which a strike depends."""

    cue_mass: float  # kg
    inverse_end_mass: float  # 1/kg, for the tip's motion across the cue; 0 if it is guided
    shaft: bool  # whether the shaft holds the tip to the axis, if that can move across it
    end_stiffness: float  # N/m, of the shaft
    tip_spring: bool  # whether the tip shears, if a shaft holds it and bodies move
    ferrule_radius: float  # m, half of the thickness of the cue at its tip
    tip_curvature: float  # radius of a rounded tip, in radii of the ball
    friction: tuple[float, float]  # of TIP_CONTACT and CLOTH_CONTACT, like the next three
    restitution: tuple[float, float]
    stiffness: tuple[float, float]  # N/m^exponent
    exponent: tuple[float, float]
    unit: float  # N/m^exponent, of the stiffnesses of balls and cushions without a duration
    tip_duration: float  # s, of a central hit
    law: int
    on_cloth: bool  # whether the contact CLOTH_CONTACT takes part
    follow_through: float  # m, see `CueParams`
    surface: BallClothParams  # the ball's own numbers are here


@inner
def tip_reach(model: StrikeModel) -> float:
    """Distance of the centres of ball and tip as they touch [m]."""
    return model.surface.radius * (1.0 + model.tip_curvature)


@lru_cache(maxsize=64)
def cue_params(model: StrikeModel, table: TableParams) -> CueParams:
    """Collect what impacts with the cue depend on, if bodies move during them or are near."""
    ball, moves = model.surface, model.law == BISTIFFNESS

    def stiffness(mass: float, duration: float, ratio: float) -> float:
        timed = moves and duration > 0.0
        return stiffness_of(mass, duration, ball.exponent) if timed else model.unit * ratio

    takes_time = moves and table.ball_duration > 0.0
    bends = model.shaft and model.inverse_end_mass > 0.0
    shears = bends and moves and model.tip_spring
    end, damping = (
        (SOFT_TIP_SHAFT_MASS, SOFT_TIP_SHAFT_DAMPING) if shears else (SHAFT_MASS, SHAFT_DAMPING)
    )
    return CueParams(
        response=1.0 / model.cue_mass,
        across=model.inverse_end_mass / (end if bends else 1.0),
        reach=tip_reach(model),
        friction=model.friction[TIP_CONTACT],
        restitution=model.restitution[TIP_CONTACT],
        stiffness=model.stiffness[TIP_CONTACT],
        exponent=model.exponent[TIP_CONTACT],
        cloth_friction=model.friction[CLOTH_CONTACT],
        cloth_restitution=model.restitution[CLOTH_CONTACT],
        cloth_stiffness=model.stiffness[CLOTH_CONTACT],
        cloth_exponent=model.exponent[CLOTH_CONTACT],
        ball_stiffness=stiffness(ball.mass, table.ball_duration, table.ball_stiffness),
        nose_stiffness=stiffness(2.0 * ball.mass, table.cushion_duration, table.cushion_stiffness),
        neighbour_reach=REACH if takes_time else table.contact_gap,
        tip_duration=model.tip_duration,
        interval=model.tip_duration / NORMALS if moves else inf,
        on_cloth=model.on_cloth,
        moves=moves,
        follow_through=model.follow_through,
        end_stiffness=model.end_stiffness if bends else 0.0,
        end_damping=damping / model.inverse_end_mass if bends else 0.0,
        shear=TIP_SHEAR if shears else 0.0,
    )


def strike_model(scene: Scene) -> StrikeModel:
    """Collect the numbers of a scene, all effects as they are called for."""
    tip, cloth = scene.contacts.cue_ball, scene.contacts.ball_table
    stiffness, unit = springs(scene)
    return StrikeModel(
        cue_mass=float(scene.cue.mass),
        inverse_end_mass=1.0 / float(scene.cue.end_mass),
        shaft=not scene.cue.guided,
        end_stiffness=float(scene.cue.end_stiffness),
        tip_spring=True,
        ferrule_radius=float(scene.cue.ferrule_radius),
        tip_curvature=float(scene.cue.tip_curvature_radius / scene.ball.radius),
        friction=(float(tip.friction), float(cloth.friction)),
        restitution=(float(tip.restitution), float(cloth.restitution)),
        stiffness=stiffness,
        exponent=(float(tip.exponent), float(cloth.exponent)),
        unit=unit,
        tip_duration=TIP_DURATION if tip.duration is None else float(tip.duration),
        law=LAWS[scene.law],
        on_cloth=True,
        follow_through=float(scene.cue.follow_through),
        surface=ball_cloth_params(scene),
    )


def springs(scene: Scene) -> tuple[tuple[float, float], float]:
    """
    Find the stiffnesses of tip and cloth, and the unit of those of balls and cushions.

    If the scene gives the ratio of the two, the tip has the stiffness with which it touches the
    ball for TIP_DURATION, as if it were elastic.
    """
    tip, cloth = scene.contacts.cue_ball, scene.contacts.ball_table
    ball, hit = scene.ball.mass, 2.0 / (1.0 / scene.cue.mass + 1.0 / scene.ball.mass)
    if tip.duration is None or cloth.duration is None:
        assert tip.stiffness is not None  # the scene has checked this
        assert cloth.stiffness is not None
        unit = stiffness_of(hit, TIP_DURATION, scene.exponent) / tip.stiffness
        return (unit * tip.stiffness, unit * cloth.stiffness), unit
    time, e = tip.duration, tip.restitution
    of_tip = stiffness_of(hit, time, tip.exponent, STROKE_SPEED, e)
    of_cloth = stiffness_of(
        2.0 * ball, cloth.duration, cloth.exponent, STROKE_SPEED, cloth.restitution
    )
    unit = stiffness_of(hit, time, scene.exponent, STROKE_SPEED, e) / TIP_STIFFNESS
    return (of_tip, of_cloth), unit


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
