"""Plan a pot from every field of a small grid."""

from billiard_shot import Scene
from billiard_shot.planning.atlas import atlas, AtlasRequest

request = AtlasRequest(ball='8', cue_grid=(3, 2), budget=300)
best = max(atlas(Scene.load('blocked'), request), key=lambda result: result.success)
print(best.layout.cue_place, best.kind, best.interval)
