"""An effect that is not there: the cloth is polished where balls slide for long."""

from billiard_shot import EventKind, predict, Scene, Stroke
from billiard_shot.table.run.effects import EffectGate, GateDecision


def slides_for_long(context):
    path = context.run.balls['cue']
    rolls = [event.time for event in path.events if event.kind == EventKind.ROLL]
    if rolls and rolls[0] > 0.5:
        return GateDecision(True, f'the cue ball slides for {rolls[0]:.2f} s')
    return GateDecision(False, 'the cue ball soon rolls')


long_slide = EffectGate(
    'long_slide',
    condition='the cue ball slides for more than half a second',
    without='the cloth is as it is elsewhere',
    evaluate=slides_for_long,
    off={'sliding_friction': 0.2},
)
draw = Stroke.from_offsets(a=0, b=-0.4, elevation=0.05, azimuth=0, speed=3.0)
print(long_slide.evaluate(predict(Scene.load('pool'), draw).effect_context))
