"""
The compiled entries of the package, and the layers whose sources they depend on.

This is the only file that names them: `machine_code` compiles what stands here.
"""

# A process compiles a group: it takes a second to begin, and compiles a function once that several
# entries of the group call. The groups take about the same time.
ENTRY_GROUPS = (
    ('billiard_shot.impact.kernel:solve_collisions',),
    (
        'billiard_shot.table.play_tables:play_tables',
        'billiard_shot.planning.score:score_tables',
        'billiard_shot.planning.direct_shots:find_direct_shots',
        'billiard_shot.planning.open_pockets:count_open_pockets',
        'billiard_shot.shot.raising:write_clear_elevations',
    ),
)
ENTRIES = tuple(name for group in ENTRY_GROUPS for name in group)
# Layers import from earlier ones. `impact` does not import from `scene`.
LAYERS = ('numerics', 'impact', 'scene', 'table', 'shot', 'planning')
