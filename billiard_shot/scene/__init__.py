"""What there is on and around the table: data read from YAML and checked, no behaviour."""

from billiard_shot.scene.effects import Effects
from billiard_shot.scene.equipment import Ball, Cloth, ContactParameters, Contacts, Cue
from billiard_shot.scene.furniture import BallBall, CornerPocket, Cushion, SidePocket, Table
from billiard_shot.scene.player import Noise, Robot
from billiard_shot.scene.rack import Rack
from billiard_shot.scene.scene import Scene

__all__ = [
    'Ball',
    'BallBall',
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
    'SidePocket',
    'Table',
]
