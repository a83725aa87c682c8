"""Scenes: the equipment and the player, as checked data that is read from YAML."""

from billiard_shot.scene.effects import Effects
from billiard_shot.scene.equipment import Ball, Cloth, ContactParameters, Contacts, Cue
from billiard_shot.scene.player import Bias, Noise, Robot
from billiard_shot.scene.rack import Rack
from billiard_shot.scene.scene import Scene, SceneLike
from billiard_shot.scene.table import BallBall, CornerPocket, Cushion, SidePocket, Table

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
