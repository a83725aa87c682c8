"""Print which effects a prediction simulated, and why."""

from billiard_shot import effects_of, predict, Stroke

shot = predict('pool', Stroke.from_offsets(a=0.2, b=0.1, elevation=0.1, azimuth=0, speed=2))
for effect in effects_of(shot):
    print(f'{effect.name:15}', effect.simulated, effect.reason)
