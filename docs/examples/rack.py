"""Break a rack of eight-ball, and let the referee rule on the break."""

from dataclasses import replace
from math import atan2

from billiard_shot import predict, Scene, Stroke
from billiard_shot.game import Call, judge, start

table = Scene.load('seven_foot')
state = start('eight_ball', table, seed=8)
print(state.in_hand, state.phase)  # kitchen break
state = state.with_cue_ball(-0.6, 0.15)

x, y = state.balls['cue']
shot = predict(
    replace(table, balls=state.balls),
    Stroke.from_offsets(0, 0.1, 0.04, atan2(-y, 0.4953 - x), 8.0),
)
ruling = judge(state, Call(), shot)
print(ruling.text)
state = ruling.state
