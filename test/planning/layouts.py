"""Scenes for plans; one for each kind of shot, where that kind is the only way."""
import math

from billiard_shot import Scene


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


def wall(x, low, high, first=1):
    """Balls side by side across the table, too near each other to go between."""
    count = math.ceil((high - low) / 0.08) + 1
    step = (high - low) / (count - 1)
    return {f'b{first + i}': (x, low + i * step) for i in range(count)}


# kind: scene, target, constraints, and a change of the constraints that takes this way away
KINDS = {
    'direct': (
        table_with(cue=(.45, -.185), b8=(.9, .265)), {'pot': '8', 'pocket': 'foot_left'},
        {'azimuth_deg': 45, 'azimuth_range_deg': 6}, {'azimuth_deg': 80}),
    'cut': (
        table_with(cue=(.5, .3), b8=(.9, .265)), {'pot': '8', 'pocket': 'foot_left'},
        {'azimuth_deg': -10, 'azimuth_range_deg': 10}, {'azimuth_deg': 45}),
    'bank': (
        table_with(cue=(.2, -.35), b8=(.45, 0), b1=(.75, .22), b2=(.7, .26), b3=(.82, .2)),
        {'pot': '8', 'pocket': 'foot_right'}, {'azimuth_deg': 50, 'azimuth_range_deg': 14},
        {'azimuth_deg': 170}),
    'kick': (
        table_with(cue=(-.6, 0), b15=(.6, 0), **wall(0, -.2, .2)), {'hit': '15'},
        {'elevation_max_deg': 12}, {'azimuth_range_deg': 20}),
    'combination': (
        table_with(cue=(.2, -.1), b1=(.75, .2), b8=(.9, .3)), {'pot': '8', 'pocket': 'foot_left'},
        {'first_contact': '1', 'azimuth_deg': 30, 'azimuth_range_deg': 10},
        {'azimuth_deg': -170}),
    'position': (
        table_with(cue=(.5, .3), b8=(.9, .265)),
        {'pot': '8', 'pocket': 'foot_left', 'leave': (.8, -.3), 'radius': .15}, {},
        {'azimuth_deg': 90, 'azimuth_range_deg': 20}),
    'curve': (
        cloth_with(cue=(-.5, 0), b8=(.5, 0), b1=(0, .02)), {'hit': '8'},
        {'elevation_max_deg': 28, 'speed_max': 2.5}, {'elevation_max_deg': 2}),
    'massé': (
        cloth_with(cue=(-.3, 0), b8=(.3, 0), **wall(0, -.12, .02),
                   **{f'b{9 + i}': (.09 * (i + 1), 0.02) for i in range(2)}), {'hit': '8'},
        {'elevation_min_deg': 45, 'speed_max': 2.5}, {'offset_max': 0.05}),
    'jump': (
        table_with(cue=(-.6, 0), b15=(.3, 0), **wall(-.1, -.28, .28)), {'hit': '15'},
        {'azimuth_range_deg': 20}, {'elevation_max_deg': 10}),
}
