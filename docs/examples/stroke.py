"""Compute the joints of a mechanism for a stroke."""

from billiard_shot import Scene, Stroke
from billiard_shot.cue.mechanism import Mechanism
from billiard_shot.cue.plan import prepare_shot, ShotPlan, tip_at
from billiard_shot.perception.sightings import Sighting

scene, balls = Scene.load('paper'), {'cue': Sighting((0.0, 0.0))}
stroke = Stroke.from_offsets(a=0.1, b=0.2, elevation=0.6, azimuth=0.0, speed=3.0)
tip = tip_at(stroke, balls['cue'].position, scene)
before = tuple(tip.position - 0.05 * tip.along)
plan = ShotPlan('shot 1', before, tip.quaternion, 3.0, tip.elevation, balls)
shot = prepare_shot(Mechanism(), scene, plan)  # raises RefusedError if a limit is violated
# Joints before the stroke; run-up in m:
print(shot.aimed.round(3))  # [-0.309 -0.003 0.344 0. 0.591 0. ]
print(round(shot.profile.contact_at, 4))  # 0.105
knots = shot.stroke.trajectory  # the first point below
print(knots.times[4], knots.positions[4].round(3))  # 0.05 [-0.309 -0.003 0.344 0. 0.591 0.105]
