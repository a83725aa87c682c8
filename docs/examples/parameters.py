"""Play three tables with different cushions."""

import numpy as np

from billiard_shot import BallState, Scene, simulate_batch

scene = Scene.load('carom')
for number in scene.parameters(['cloth.rolling_resistance', 'table.cushion.restitution']):
    print(number.name, number.value, number.low, number.high, number.published, number.source)
start = BallState(np.tile((0.2, 0.1, scene.ball.radius), (3, 1)), (1.5, 0.7, 0.0))
restitution = {'table.cushion.restitution': [0.7, 0.8, 0.9]}
runs = simulate_batch(scene, {'cue': start}, until=2.0, at=[0.5, 1.0], parameters=restitution)
print(runs.position_at[:, 0], 'm')
