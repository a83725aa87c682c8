"""An effect that is not there: the cloth is polished where balls slide for long."""

from billiard_shot import EventKind, predict, Scene, Stroke
from billiard_shot.table.run.effects import gate


@gate(
    'the cue ball slides for more than half a second',
    'the cloth is as it is elsewhere',
    off={'sliding_friction': 0.2},
)
def long_slide(shot):
    path = shot.run.balls['cue']
    rolls = [event.time for event in path.events if event.kind == EventKind.ROLL]
    if rolls and rolls[0] > 0.5:
        return True, f'the cue ball slides for {rolls[0]:.2f} s'
    return False, 'the cue ball soon rolls'


draw = Stroke.from_offsets(a=0, b=-0.4, elevation=0.05, azimuth=0, speed=3.0)
print(long_slide.evaluate(predict(Scene.load('pool'), draw).effect_context))
