"""Play a stroke 200 times as a player executes it."""

import numpy as np

from billiard_shot import predict_batch, Scene

scene, draw = Scene.load('blocked'), np.random.default_rng(1)
planned = [0.0, 0.1, 0.07, -0.4, 2.0]  # a, b (ball radii), elevation, azimuth (rad), speed (m/s)
played = scene.noise.sample(planned, 200, draw, scene.ball.radius)
batch = predict_batch(scene, offsets=played)
print(batch, batch.final_position[:, 0, :2].std(axis=0), 'm')
