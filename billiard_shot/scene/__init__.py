"""Scenes: the equipment and the player, as checked data that is read from YAML."""

from billiard_shot.scene.equipment import (
    Ball,
    BallBall,
    Cloth,
    ContactParameters,
    Contacts,
    CornerPocket,
    Cue,
    Cushion,
    SidePocket,
    Table,
)
from billiard_shot.scene.placement import Rack
from billiard_shot.scene.player import Bias, Noise, Robot
from billiard_shot.scene.scene import Effects, Scene, SceneLike

__all__ = [
    'Ball',
    'BallBall',
    'Bias',
    'Cloth',
    'ContactParameters',
    'Contacts',
    'CornerPocket',
    'Cue',
    'Cushion',
    'Effects',
    'Noise',
    'Rack',
    'Robot',
    'Scene',
    'SceneLike',
    'SidePocket',
    'Table',
]
