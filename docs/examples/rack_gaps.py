"""Break racks with gaps of different sizes."""

from billiard_shot import Scene
from studies.rack_gaps import break_speeds, without_duration

pool = Scene.load('pool')
for gap in (0.0, 1e-6, 1e-4, 1e-3):  # m
    slow, instant = ((break_speeds(s, gap) < 0.5).sum() for s in (pool, without_duration(pool)))
    print(f'{gap:7g} m: {slow:2} of 15 balls below 0.5 m/s, {instant:2} if contacts took no time')
#       0 m:  1 of 15 balls below 0.5 m/s,  1 if contacts took no time
#   1e-06 m:  1 of 15 balls below 0.5 m/s, 13 if contacts took no time
#  0.0001 m:  3 of 15 balls below 0.5 m/s, 13 if contacts took no time
#   0.001 m: 13 of 15 balls below 0.5 m/s, 13 if contacts took no time
