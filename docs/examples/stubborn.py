"""A player that hides another one, and plays a rack against it."""

from billiard_shot import Scene
from billiard_shot.game import find_agent, Pairing, play


class Stubborn:
    def __init__(self, scene, seed):
        self.greedy = find_agent('greedy')(scene, seed)

    def place(self, state):  # the cue ball is in hand
        return self.greedy.place(state)

    def decide(self, state):  # a stroke with its call, or one of the choices
        return self.greedy.decide(state)

    def saw(self, state, decision, ruling):  # every shot of both players
        pass


make = Stubborn
rack = play(Pairing('nine_ball', Scene.load('seven_foot'), ('random', 'random'), seed=3), number=0)
print(rack.winner)  # random
