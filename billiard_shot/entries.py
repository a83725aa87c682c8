"""
The compiled entries of the package, and the layers whose sources they depend on.

This is the only file that names them: `billiard_shot.compiler` compiles what stands here.
"""

ENTRIES = (
    'billiard_shot.impact.kernel:solve_collisions',
    'billiard_shot.table.run.play_tables:play_tables',
    'billiard_shot.planning.score:score_tables',
    'billiard_shot.planning.direct_shots:find_direct_shots',
    'billiard_shot.planning.shots:count_open_pockets',
    'billiard_shot.shot.stroke:write_strokes',
    'billiard_shot.shot.lowest_elevation:write_clear_elevations',
)
# Layers import from earlier ones. `impact` does not import from `scene`.
LAYERS = ('numerics', 'impact', 'scene', 'table', 'shot', 'planning')
