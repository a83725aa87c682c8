"""Rate the direct shots at the 8 of two tables."""

from billiard_shot import BallState, Scene, shots

scene = Scene.load('pool_table')
places = {'cue': (-0.5, 0.0), '1': (0.5, 0.1), '8': (0.9, 0.3)}
table = {name: BallState((x, y, scene.ball.radius)) for name, (x, y) in places.items()}
found = shots(scene, [table, {'cue': table['cue'], '8': table['8']}], legal=['8'])
print(found.chance, found.offsets)
print('best of each table:', found.best)
