"""The numbers of a scene that a strike depends on, in the form that compiled code takes."""

from typing import NamedTuple

from billiard_shot.compiled import inner
from billiard_shot.impact.laws import LAWS
from billiard_shot.impact.solve import Properties
from billiard_shot.scene import Scene
from billiard_shot.table.contact_duration import stiffness_of
from billiard_shot.table.model import ball_cloth_params
from billiard_shot.table.params import BallClothParams

TIP, TABLE = 0, 1  # the contacts: cue on ball, ball on table
# Of tip and ball, at DURATION_SPEED [s]: high-speed films, Alciatore (billiards.colostate.edu).
TIP_DURATION = 1.3e-3


class StrikeModel(NamedTuple):
    """What a strike depends on, beside the stroke."""

    cue_mass: float  # kg
    inverse_end_mass: float  # 1/kg, for the tip's motion across the cue; 0 if it is guided
    ferrule_radius: float  # m, half of the thickness of the cue at its tip
    tip_curvature: float  # radius of a rounded tip, in radii of the ball
    friction: tuple[float, float]  # of TIP and TABLE, like the next two
    restitution: tuple[float, float]
    stiffness: tuple[float, float]  # only the ratio matters
    law: int
    exponent: float
    table: bool  # whether the contact TABLE takes part
    follows: bool  # whether the cue goes on after the strike, and may hit the ball again
    surface: BallClothParams  # the ball's own numbers are here


@inner
def tip_reach(model: StrikeModel) -> float:
    """Distance of the centres of ball and tip as they touch [m]."""
    return model.surface.radius * (1.0 + model.tip_curvature)


def tip_stiffness(model: StrikeModel) -> float:
    """Stiffness [N/m^exponent] with which the contact of tip and ball has TIP_DURATION."""
    effective = 1.0 / (1.0 / model.cue_mass + 1.0 / model.surface.mass)
    return stiffness_of(2.0 * effective, TIP_DURATION, model.exponent)


def strike_model(scene: Scene) -> StrikeModel:
    """Collect the numbers of a scene, all effects as they are called for."""
    tip, table = scene.contacts.cue_ball, scene.contacts.ball_table
    return StrikeModel(
        cue_mass=float(scene.cue.mass),
        inverse_end_mass=1.0 / float(scene.cue.end_mass),
        ferrule_radius=float(scene.cue.ferrule_radius),
        tip_curvature=float(scene.cue.tip_curvature_radius / scene.ball.radius),
        friction=(float(tip.friction), float(table.friction)),
        restitution=(float(tip.restitution), float(table.restitution)),
        stiffness=(float(tip.stiffness), float(table.stiffness)),
        law=LAWS[scene.law],
        exponent=float(scene.exponent),
        table=True,
        follows=True,
        surface=ball_cloth_params(scene),
    )


def contact_properties(model: StrikeModel) -> Properties:
    """Collect what the impact solver needs to know of the contacts TIP and TABLE."""
    return Properties(
        model.friction, model.restitution, model.stiffness, model.law, model.exponent
    )
