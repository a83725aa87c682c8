from dataclasses import replace

import numpy as np

from billiard_shot import calibrate, predict, Scene
from billiard_shot.calibration.simulator import recording_of
from billiard_shot.scene import Noise

scene = replace(Scene.load('carom'), noise=Noise(speed=0.02))


def simulator(scene, stroke, errors):  # yours; this one has another cloth
    there = scene.with_parameters(['cloth.sliding_friction'], [0.23])
    shot = predict(there, scene.noise.perturb(stroke, errors, scene.ball.radius))
    times = np.arange(0.0, shot.run.duration, 0.05)
    balls = shot.run.at(times)
    return {name: np.c_[times, ball.position[:, :2]] for name, ball in balls.items()}


shots = recording_of(simulator, scene, shots=8)
found = calibrate(shots, scene, names=['cloth.sliding_friction'], horizon=0.5)
print(f'{found.estimates[0].value:.2f}')  # 0.23
