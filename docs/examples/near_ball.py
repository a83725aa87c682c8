"""Strike the cue ball at different distances from a ball in front of it."""

from math import radians

from billiard_shot import predict, Scene, Stroke

pool, ball = Scene.load('pool').to_dict(), Scene.load('pool').ball
stroke = Stroke.from_offsets(a=0, b=0.1, elevation=radians(5), azimuth=0, speed=2)
for gap in (0.0, 1e-4, 1e-3, 1e-2):  # m
    pool['balls'] = {'cue': [0, 0], '1': [2 * ball.radius + gap, 0]}
    shot = predict(Scene.from_dict(pool), stroke)
    cue, one = (state.velocity[0] for state in shot.run.at(0.02).values())
    print(f'{gap:5g} m: cue ball {cue:.2f} m/s, ball 1 {one:.2f} m/s')
#     0 m: cue ball 1.98 m/s, ball 1 2.10 m/s
# 0.0001 m: cue ball 1.77 m/s, ball 1 2.21 m/s
# 0.001 m: cue ball 1.42 m/s, ball 1 2.47 m/s
#  0.01 m: cue ball 1.52 m/s, ball 1 2.42 m/s
