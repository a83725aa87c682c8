"""Play five tables at once; the last one has no ball 1."""

import numpy as np

from billiard_shot import BallState, Scene, simulate_batch

scene = Scene.load('pool_table')
r = scene.ball.radius
speeds = np.zeros((5, 3))
speeds[:, 0] = np.linspace(1.0, 3.0, 5)
states = {'cue': BallState((-0.5, 0.0, r), speeds), '1': BallState((0.5, 0.01, r))}
tables = simulate_batch(scene, states, present=[[True, True]] * 4 + [[True, False]])
print(tables.motion, tables.first_met[:, 0])
