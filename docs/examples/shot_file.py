"""Save a shot, and load it again."""

from billiard_shot import load_shot, predict, save_shot, Stroke

shot = predict('pool', Stroke.from_offsets(a=0.2, b=0.1, elevation=0.1, azimuth=0, speed=2))
save_shot(shot, 'shot.json')
again = load_shot('shot.json')
print((again.velocity == shot.velocity).all(), again.message == shot.message)  # True True
