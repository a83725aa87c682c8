"""Play a rack on a table of pooltool, with a scene that is fitted to it."""

from dataclasses import replace

from restored import GAME

from billiard_shot import calibrate, Scene
from billiard_shot.game import Pairing, play
from billiard_shot.game.pooltool import Pooltool

table = Pooltool()
found = calibrate(table.recorded, replace(Scene.load('seven_foot'), balls={}))
print(found, *found.notes, sep='\n')
scene = replace(found.scene, robot=replace(found.scene.robot, speed_max=8.0))
players = 'player:effort=0.5', 'greedy'
rack = play(Pairing(GAME, scene, players, simulator=table.foreign), number=0)
print(rack.winner)
