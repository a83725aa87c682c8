"""Simulate a break from the states of the balls."""

from billiard_shot import BallState, Scene, simulate

scene = Scene.load('nine_ball')
r = scene.ball.radius
states = {name: BallState((x, y, r)) for name, (x, y) in scene.balls.items()}
states['cue'] = BallState(states['cue'].position, (8, -0.8, 0))
run = simulate(scene, states)
print(run.status, run.pocketed, len(run.events))
print(run.at(0.5)['1'].position, run.final_position['9'])
