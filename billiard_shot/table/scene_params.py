"""A scene's numbers in the form that compiled code takes: ball and cloth, table and contacts."""

import math

from billiard_shot.impact.laws import LAWS
from billiard_shot.scene import Scene
from billiard_shot.scene.table import Pocket
from billiard_shot.table.cushion_models import CUSHION_MODELS, HAN
from billiard_shot.table.params import BallClothParams, GATE_AUTO, Mouth, TableParams
from billiard_shot.table.rolling_boundary import DEPTH_IN_MOUTH


def ball_cloth_params(scene: Scene) -> BallClothParams:
    """Collect what the motion of a ball on the cloth depends on, all effects as called for."""
    ball, cloth, table = scene.ball, scene.cloth, scene.contacts.ball_table
    return BallClothParams(
        mass=float(ball.mass),
        radius=float(ball.radius),
        inertia=float(ball.inertia),
        gravity=float(cloth.gravity),
        sliding_friction=float(cloth.sliding_friction),
        rolling_resistance=float(cloth.rolling_resistance),
        rolling_rise=float(cloth.rolling_rise),
        spin_deceleration=float(cloth.spin_deceleration),
        cloth_restitution=float(table.restitution),
        cloth_friction=float(table.friction),
        law=LAWS[scene.law],
        exponent=float(scene.exponent),
        flight_gate=GATE_AUTO,
        bounce_gate=GATE_AUTO,
    )


_NO_MOUTH = (1.0, 1.0, 0.0, 0.0, 0.0)
ENDLESS = TableParams(
    length=math.inf,
    width=math.inf,
    pockets=False,
    cushion_model=HAN,
    cushion_restitution=0.0,
    cushion_friction=0.0,
    cushion_early_fading=0.0,
    cushion_fading=0.0,
    cushion_frequency_ratio=0.0,
    cushion_stiffness=1.0,
    cushion_duration=0.0,
    nose_height=0.0,
    cushion_depth=0.0,
    corner=_NO_MOUTH,
    side=_NO_MOUTH,
    corner_hole=(0.0, 0.0),
    side_hole=(0.0, 0.0),
    ball_restitution=1.0,
    friction_fast=0.0,
    friction_slow=0.0,
    friction_decay=0.0,
    ball_stiffness=1.0,
    ball_duration=0.0,
    contact_gap=DEPTH_IN_MOUTH,
)
"""Cloth without end, for one ball."""


def table_params(scene: Scene) -> TableParams:
    """Collect what there is to meet, all effects as called for; without a table no end."""
    table, balls = scene.table, scene.contacts.ball_ball
    params = ENDLESS._replace(
        ball_restitution=float(balls.restitution),
        friction_fast=float(balls.friction_fast),
        friction_slow=float(balls.friction_slow),
        friction_decay=float(balls.friction_decay),
        ball_stiffness=float(balls.stiffness),
        ball_duration=float(balls.duration),
        # Those that collide may be as far apart, or as deep in each other where they were pressed
        # together: they must be among those in touch.
        contact_gap=max(float(balls.gap), DEPTH_IN_MOUTH),
    )
    if table is None:
        return params
    cushion, corner, side = table.cushion, table.corner, table.side
    return params._replace(
        length=float(table.length),
        width=float(table.width),
        pockets=table.pockets,
        cushion_model=CUSHION_MODELS[cushion.model],
        cushion_restitution=float(cushion.restitution),
        cushion_friction=float(cushion.friction),
        cushion_early_fading=float(cushion.early_fading),
        cushion_fading=float(cushion.fading),
        cushion_frequency_ratio=float(cushion.frequency_ratio),
        cushion_stiffness=float(cushion.stiffness),
        cushion_duration=float(cushion.duration),
        nose_height=2.0 * scene.ball.radius * cushion.height,
        cushion_depth=float(cushion.depth),
        corner=_mouth(corner),
        side=_mouth(side),
        corner_hole=(corner.shelf + corner.radius - 0.5 * corner.mouth, float(corner.radius)),
        side_hole=(side.shelf + side.radius, float(side.radius)),
    )


def _mouth(pocket: Pocket) -> Mouth:
    """Mouth, sine and cosine of the turn from nose to facing, radius and setback of the jaws."""
    turn = math.radians(180.0 - pocket.cut_deg)
    return (
        float(pocket.mouth),
        math.sin(turn),
        math.cos(turn),
        float(pocket.jaw_radius),
        pocket.jaw_radius * math.tan(0.5 * turn),
    )
