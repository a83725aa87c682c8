"""A gate for an effect that is not there: the cloth is polished where balls slide for long."""

from billiard_shot import EventKind, predict, Scene, Stroke
from billiard_shot.table.effects import EffectContext, EffectGate, GateDecision


class LongSlide(EffectGate[EffectContext]):
    """Simulated where the cue ball slides for more than half a second."""

    name = 'long_slide'
    condition = 'the cue ball slides for more than half a second'
    overrides = {'off': {'sliding_friction': 0.2}}  # what the number is without the effect

    def evaluate(self, context):
        path = context.run.balls['cue']
        rolls = [event.time for event in path.events if event.kind == EventKind.ROLL]
        if rolls and rolls[0] > 0.5:
            return GateDecision(True, f'the cue ball slides for {rolls[0]:.2f} s')
        return GateDecision(False, 'the cue ball soon rolls')


draw = Stroke.from_offsets(a=0, b=-0.4, elevation=0.05, azimuth=0, speed=3.0)
print(LongSlide().evaluate(predict(Scene.load('pool'), draw).effect_context))
