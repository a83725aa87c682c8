"""A scene's numbers in the form that compiled code takes."""
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.impact.laws import LAWS
from billiard_shot.scene import Scene
from billiard_shot.table.model import surface_of
from billiard_shot.table.surface import Surface

TIP, TABLE = 0, 1  # the contacts: cue on ball, ball on table


class Model(NamedTuple):
    """What a strike depends on, beside the stroke."""

    cue_mass: float  # kg
    softness: float  # 1/kg, of the tip's sideways motion: one over the end mass, 0 if guided
    tip_radius: float  # m
    dome: float  # of a rounded tip, in radii of the ball
    friction: NDArray[np.float64]  # (2,), of TIP and TABLE, like the next two
    restitution: NDArray[np.float64]
    stiffness: NDArray[np.float64]
    law: int
    exponent: float
    table: bool  # whether the contact TABLE takes part
    surface: Surface  # the ball's own numbers are here


def numbers_of(scene: Scene) -> Model:
    """Collect the numbers of a scene, all effects as they are called for."""
    tip, table = scene.contacts.cue_ball, scene.contacts.ball_table
    return Model(
        cue_mass=scene.cue.mass,
        softness=1.0 / scene.cue.end_mass,
        tip_radius=scene.cue.tip_radius,
        dome=scene.cue.dome / scene.ball.radius,
        friction=np.array([tip.friction, table.friction]),
        restitution=np.array([tip.restitution, table.restitution]),
        stiffness=np.array([tip.stiffness, table.stiffness]),
        law=LAWS[scene.law],
        exponent=scene.exponent,
        table=True,
        surface=surface_of(scene),
    )
