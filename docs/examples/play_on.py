"""Plan and play two shots as a player does."""

import numpy as np

from billiard_shot import plan, predict, Scene

scene, errors = Scene.load('blocked'), np.random.default_rng(1)
for _ in range(2):
    best = plan(scene, {'pot': 'any'}, budget=4000).best
    shot = predict(scene, scene.noise.perturb(best.stroke, errors))
    print(shot.message)
    scene = shot.after()
