"""The numbers of a scene that a strike depends on, in the form that compiled code takes."""

from functools import lru_cache
from math import inf, radians, sin
from typing import NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact.laws import BISTIFFNESS, LAWS
from billiard_shot.scene import Scene
from billiard_shot.table.contact_duration import stiffness_of, STROKE_SPEED
from billiard_shot.table.cue import CueParams
from billiard_shot.table.cue_impact import CLOTH_CONTACT, TIP_CONTACT
from billiard_shot.table.params import BallClothParams, TableParams
from billiard_shot.table.scene_params import ball_cloth_params

REACH = 0.03  # m: farther than a ball goes while the tip of a cue at 10 m/s touches it
NORMALS = 16  # that a contact has while the tip touches the ball
NORMALS_MOVE_FROM = radians(35.0)  # elevation [rad], see docs/limits.md
# Of tip and ball at DURATION_SPEED [s], if the scene has only a ratio of stiffnesses: high-speed
# films, Alciatore (billiards.colostate.edu).
TIP_DURATION = 1.3e-3
# Of a tip with a duration, in the unit of the stiffnesses of balls and cushions; as in the paper.
TIP_STIFFNESS = 1.5


class StrikeModel(NamedTuple):
    """The numbers of a scene on which a strike depends."""

    cue_mass: float  # kg
    inverse_end_mass: float  # 1/kg, for the tip's motion across the cue; 0 if it is guided
    ferrule_radius: float  # m, half of the thickness of the cue at its tip
    tip_curvature: float  # radius of a rounded tip, in radii of the ball
    friction: tuple[float, float]  # of TIP_CONTACT and CLOTH_CONTACT, like the next two
    restitution: tuple[float, float]
    stiffness: tuple[float, float]  # N/m^exponent
    unit: float  # N/m^exponent, of the stiffnesses of balls and cushions without a duration
    tip_duration: float  # s, of a central hit
    law: int
    exponent: float
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
        return stiffness_of(mass, duration, model.exponent) if timed else model.unit * ratio

    takes_time = moves and table.ball_duration > 0.0
    return CueParams(
        response=1.0 / model.cue_mass,
        across=model.inverse_end_mass,
        reach=tip_reach(model),
        friction=model.friction[TIP_CONTACT],
        restitution=model.restitution[TIP_CONTACT],
        stiffness=model.stiffness[TIP_CONTACT],
        cloth_friction=model.friction[CLOTH_CONTACT],
        cloth_restitution=model.restitution[CLOTH_CONTACT],
        cloth_stiffness=model.stiffness[CLOTH_CONTACT],
        ball_stiffness=stiffness(ball.mass, table.ball_duration, table.ball_stiffness),
        nose_stiffness=stiffness(2.0 * ball.mass, table.cushion_duration, table.cushion_stiffness),
        neighbour_reach=REACH if takes_time else table.contact_gap,
        tip_duration=model.tip_duration,
        interval=model.tip_duration / NORMALS if moves else inf,
        on_cloth=model.on_cloth,
        moves=moves,
        follow_through=model.follow_through,
        normals_move_from=sin(NORMALS_MOVE_FROM) if moves and model.follow_through > 0.0 else inf,
    )


def strike_model(scene: Scene) -> StrikeModel:
    """Collect the numbers of a scene, all effects as they are called for."""
    tip, cloth = scene.contacts.cue_ball, scene.contacts.ball_table
    stiffness, unit = springs(scene)
    return StrikeModel(
        cue_mass=float(scene.cue.mass),
        inverse_end_mass=1.0 / float(scene.cue.end_mass),
        ferrule_radius=float(scene.cue.ferrule_radius),
        tip_curvature=float(scene.cue.tip_curvature_radius / scene.ball.radius),
        friction=(float(tip.friction), float(cloth.friction)),
        restitution=(float(tip.restitution), float(cloth.restitution)),
        stiffness=stiffness,
        unit=unit,
        tip_duration=TIP_DURATION if tip.duration is None else float(tip.duration),
        law=LAWS[scene.law],
        exponent=float(scene.exponent),
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
    ball, exponent = scene.ball.mass, scene.exponent
    hit = 2.0 / (1.0 / scene.cue.mass + 1.0 / ball)
    if tip.duration is None or cloth.duration is None:
        assert tip.stiffness is not None  # the scene has checked this
        assert cloth.stiffness is not None
        unit = stiffness_of(hit, TIP_DURATION, exponent) / tip.stiffness
        return (unit * tip.stiffness, unit * cloth.stiffness), unit
    of_tip = stiffness_of(hit, tip.duration, exponent, STROKE_SPEED, tip.restitution)
    of_cloth = stiffness_of(2.0 * ball, cloth.duration, exponent, STROKE_SPEED, cloth.restitution)
    return (of_tip, of_cloth), of_tip / TIP_STIFFNESS
