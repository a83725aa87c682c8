"""Find the shot after which a direct shot at the 8 is most likely to succeed."""

from billiard_shot import plan, Scene, shots

scene = Scene.load('blocked')


def next_shot(outcomes):
    potted = outcomes.pocket[:, outcomes.names.index('1')] >= 0
    return potted * shots(scene, outcomes.states, ['8'], workers=1).best


best = plan(scene, {'pot': '1'}, budget=4000, value=next_shot).best
print(best.success, best.value, best.value_error, best.stroke)
