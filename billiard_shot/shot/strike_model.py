"""The numbers of a scene that a strike depends on, in the form that compiled code takes."""

from functools import lru_cache
from math import inf, radians, sin
from typing import NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact.laws import BISTIFFNESS, LAWS
from billiard_shot.scene import Scene
from billiard_shot.table.contact_duration import stiffness_of
from billiard_shot.table.cue import CueParams, TIP_DURATION
from billiard_shot.table.cue_impact import CLOTH_CONTACT, TIP_CONTACT
from billiard_shot.table.params import BallClothParams, TableParams
from billiard_shot.table.scene_params import ball_cloth_params

REACH = 0.03  # m: farther than a ball goes while the tip of a cue at 10 m/s touches it
NORMALS = 16  # that a contact has in TIP_DURATION
# The bending shaft as a lighter end with a dashpot: its mass relative to the effective mass of the
# cue's end, and the rate [1/s] at which it loses its motion, per that mass. 4 kg/s for an end of
# 4.2 g agree with a maple shaft, a chain of masses on a beam. The mass is fitted: squirt at 0.1 to
# 0.5 radii is within 5 percent of that of a free end of the effective mass.
SHAFT_MASS, SHAFT_DAMPING = 0.62, 950.0
NORMALS_MOVE_FROM = radians(35.0)  # elevation [rad], see docs/limits.md


class StrikeModel(NamedTuple):
    """The numbers of a scene on which a strike depends."""

    cue_mass: float  # kg
    inverse_end_mass: float  # 1/kg, for the tip's motion across the cue; 0 if it is guided
    shaft: bool  # whether the shaft holds the tip to the axis, if that can move across it
    end_stiffness: float  # N/m, of the shaft
    ferrule_radius: float  # m, half of the thickness of the cue at its tip
    tip_curvature: float  # radius of a rounded tip, in radii of the ball
    friction: tuple[float, float]  # of TIP_CONTACT and CLOTH_CONTACT, like the next three
    restitution: tuple[float, float]
    stiffness: tuple[float, float]  # only the ratio matters
    exponent: tuple[float, float]
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
    """
    Collect what impacts with the cue depend on, if bodies move during them or are near.

    If bodies move, the contact of tip and ball has the stiffness that makes it last TIP_DURATION;
    a contact without a duration of its own keeps its ratio to that.
    """
    ball, moves = model.surface, model.law == BISTIFFNESS
    unit = 1.0
    if moves:
        effective = 1.0 / (1.0 / model.cue_mass + 1.0 / ball.mass)
        unit = (
            stiffness_of(2.0 * effective, TIP_DURATION, model.exponent[TIP_CONTACT])
            / model.stiffness[TIP_CONTACT]
        )

    def stiffness(mass: float, duration: float, ratio: float) -> float:
        timed = moves and duration > 0.0
        return stiffness_of(mass, duration, ball.exponent) if timed else unit * ratio

    takes_time = moves and table.ball_duration > 0.0
    bends = model.shaft and model.inverse_end_mass > 0.0
    return CueParams(
        response=1.0 / model.cue_mass,
        across=model.inverse_end_mass / (SHAFT_MASS if bends else 1.0),
        reach=tip_reach(model),
        friction=model.friction[TIP_CONTACT],
        restitution=model.restitution[TIP_CONTACT],
        stiffness=unit * model.stiffness[TIP_CONTACT],
        exponent=model.exponent[TIP_CONTACT],
        cloth_friction=model.friction[CLOTH_CONTACT],
        cloth_restitution=model.restitution[CLOTH_CONTACT],
        cloth_stiffness=unit * model.stiffness[CLOTH_CONTACT],
        cloth_exponent=model.exponent[CLOTH_CONTACT],
        ball_stiffness=stiffness(ball.mass, table.ball_duration, table.ball_stiffness),
        nose_stiffness=stiffness(2.0 * ball.mass, table.cushion_duration, table.cushion_stiffness),
        neighbour_reach=REACH if takes_time else table.contact_gap,
        interval=TIP_DURATION / NORMALS if moves else inf,
        on_cloth=model.on_cloth,
        moves=moves,
        follow_through=model.follow_through,
        end_stiffness=model.end_stiffness if bends else 0.0,
        end_damping=SHAFT_DAMPING / model.inverse_end_mass if bends else 0.0,
        normals_move_from=sin(NORMALS_MOVE_FROM) if moves and model.follow_through > 0.0 else inf,
    )


def strike_model(scene: Scene) -> StrikeModel:
    """Collect the numbers of a scene, all effects as they are called for."""
    tip, cloth = scene.contacts.cue_ball, scene.contacts.ball_table
    return StrikeModel(
        cue_mass=float(scene.cue.mass),
        inverse_end_mass=1.0 / float(scene.cue.end_mass),
        shaft=not scene.cue.guided,
        end_stiffness=float(scene.cue.end_stiffness),
        ferrule_radius=float(scene.cue.ferrule_radius),
        tip_curvature=float(scene.cue.tip_curvature_radius / scene.ball.radius),
        friction=(float(tip.friction), float(cloth.friction)),
        restitution=(float(tip.restitution), float(cloth.restitution)),
        stiffness=(float(tip.stiffness), float(cloth.stiffness)),
        exponent=(float(tip.exponent), float(cloth.exponent)),
        law=LAWS[scene.law],
        on_cloth=True,
        follow_through=float(scene.cue.follow_through),
        surface=ball_cloth_params(scene),
    )
