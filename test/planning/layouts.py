"""Scenes for plans; one for each kind of shot, where that kind is the only way."""

import math

from billiard_shot import Scene
from billiard_shot.planning.problem import limits_of, problem_of
from billiard_shot.planning.targets import target_of
from billiard_shot.scene.player import NOISES


def table_with(**balls):
    """Nine-foot table with the cue ball and others, `b8` for ball 8."""
    data = Scene.load('pool_table').to_dict()
    data['balls'] = {name.removeprefix('b'): place for name, place in balls.items()}
    return Scene.from_dict(data)


def cloth_with(**balls):
    """Endless cloth with balls: no cushion leads around anything."""
    data = Scene.load('pool').to_dict()
    data['balls'] = {name.removeprefix('b'): place for name, place in balls.items()}
    return Scene.from_dict(data)


def problem(scene, target, noise=NOISES['tournament'], constraints=None):
    """What a search has to solve."""
    limits = limits_of(scene, constraints, noise)
    return problem_of(scene, target_of(scene, target), limits, noise)


def wall(x, low, high, first=1):
    """Balls side by side across the table, too near each other to go between."""
    count = math.ceil((high - low) / 0.08) + 1
    step = (high - low) / (count - 1)
    return {f'b{first + i}': (x, low + i * step) for i in range(count)}


# kind: scene, target, constraints, and a change of the constraints that takes this way away
KINDS = {
    'direct': (
        table_with(cue=(0.45, -0.185), b8=(0.9, 0.265)),
        {'pot': '8', 'pocket': 'foot_left'},
        {'azimuth_deg': 45, 'azimuth_half_range_deg': 6},
        {'azimuth_deg': 80},
    ),
    'cut': (
        table_with(cue=(0.5, 0.3), b8=(0.9, 0.265)),
        {'pot': '8', 'pocket': 'foot_left'},
        {'azimuth_deg': -10, 'azimuth_half_range_deg': 10},
        {'azimuth_deg': 45},
    ),
    'bank': (
        table_with(
            cue=(0.2, -0.35), b8=(0.45, 0), b1=(0.75, 0.22), b2=(0.7, 0.26), b3=(0.82, 0.2)
        ),
        {'pot': '8', 'pocket': 'foot_right'},
        {'azimuth_deg': 50, 'azimuth_half_range_deg': 14},
        {'azimuth_deg': 170},
    ),
    'kick': (
        table_with(cue=(-0.6, 0), b15=(0.6, 0), **wall(0, -0.2, 0.2)),
        {'hit': '15'},
        {'elevation_max_deg': 12},
        {'azimuth_half_range_deg': 20},
    ),
    'combination': (
        table_with(cue=(0.2, -0.1), b1=(0.75, 0.2), b8=(0.9, 0.3)),
        {'pot': '8', 'pocket': 'foot_left'},
        {'first_contact': '1', 'azimuth_deg': 30, 'azimuth_half_range_deg': 10},
        {'azimuth_deg': -170},
    ),
    'position': (
        table_with(cue=(0.5, 0.3), b8=(0.9, 0.265)),
        {'pot': '8', 'pocket': 'foot_left', 'leave': (0.8, -0.3), 'radius': 0.15},
        {},
        {'azimuth_deg': 90, 'azimuth_half_range_deg': 20},
    ),
    'curve': (
        cloth_with(cue=(-0.5, 0), b8=(0.5, 0), b1=(0, 0.02)),
        {'hit': '8'},
        {'elevation_max_deg': 28, 'speed_max': 2.5},
        {'elevation_max_deg': 2},
    ),
    'massé': (
        cloth_with(
            cue=(-0.3, 0),
            b8=(0.3, 0),
            **wall(0, -0.12, 0.02),
            **{f'b{9 + i}': (0.09 * (i + 1), 0.02) for i in range(2)},
        ),
        {'hit': '8'},
        {'elevation_min_deg': 45, 'speed_max': 2.5},
        {'offset_max': 0.05},
    ),
    'jump': (
        table_with(cue=(-0.6, 0), b15=(0.3, 0), **wall(-0.1, -0.28, 0.28)),
        {'hit': '15'},
        {'azimuth_half_range_deg': 20},
        {'elevation_max_deg': 10},
    ),
}
