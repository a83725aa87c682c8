"""Plan a pot from every place of a small grid."""

from billiard_shot import Scene
from billiard_shot.planning.success_map import success_map

made = success_map(Scene.load('blocked'), '8', (3, 2), budget=300)
row, column = divmod(int(made.success.argmax()), len(made.x))
print(made.x[column], made.y[row], made.low[row, column], made.high[row, column])
