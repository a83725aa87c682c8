"""A scene's numbers in the form that compiled code takes: ball and cloth, table and contacts."""

import math

from billiard_shot.impact.laws import LAWS
from billiard_shot.scene import Scene
from billiard_shot.scene.table import Pocket
from billiard_shot.table.params import AUTO, BallClothParams, HAN, MATHAVAN, Mouth, TableParams
from billiard_shot.table.rolling_boundary import BEYOND

_CUSHIONS = {'han': HAN, 'mathavan': MATHAVAN}


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
        spin_deceleration=float(cloth.spin_deceleration),
        cloth_restitution=float(table.restitution),
        cloth_friction=float(table.friction),
        cloth_stiffness=float(table.stiffness),
        law=LAWS[scene.law],
        exponent=float(scene.exponent),
        flight_gate=AUTO,
        bounce_gate=AUTO,
    )


def table_params(scene: Scene) -> TableParams:
    """Collect what there is to meet, all effects as called for; without a table no end."""
    table, balls = scene.table, scene.contacts.ball_ball
    if table is None:
        length, width, model, numbers = math.inf, math.inf, HAN, (0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
        height, depth, pockets = float(scene.ball.radius), 0.0, False
        corner = side = (1.0, 1.0, 0.0, 0.0, 0.0)
        corner_hole = side_hole = (0.0, 0.0)
    else:
        cushion = table.cushion
        length, width, pockets = float(table.length), float(table.width), table.pockets
        model = _CUSHIONS[cushion.model]
        numbers = (
            float(cushion.restitution),
            float(cushion.friction),
            float(cushion.fading),
            float(cushion.frequency_ratio),
            float(cushion.stiffness),
            float(cushion.duration),
        )
        height, depth = 2.0 * scene.ball.radius * cushion.height, float(cushion.depth)
        corner, side = _mouth(table.corner), _mouth(table.side)
        corner_hole = (
            table.corner.shelf + table.corner.radius - 0.5 * table.corner.mouth,
            float(table.corner.radius),
        )
        side_hole = table.side.shelf + table.side.radius, float(table.side.radius)
    return TableParams(
        length,
        width,
        pockets,
        model,
        *numbers,
        height,
        depth,
        corner,
        side,
        corner_hole,
        side_hole,
        float(balls.restitution),
        float(balls.friction_fast),
        float(balls.friction_slow),
        float(balls.friction_decay),
        float(balls.stiffness),
        float(balls.duration),
        # Those that collide may be as far apart, or as deep in each other where they were pressed
        # together: they must be among those in touch.
        max(float(balls.gap), BEYOND),
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
