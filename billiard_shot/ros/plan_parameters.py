"""Parameters of the planner's node."""

import yaml

from billiard_shot.planning.targets import KINDS
from billiard_shot.ros.parameters import NodeParameter, TABLE_FRAME
from billiard_shot.scene import Scene


def _target(text: str) -> None:
    """Raise ValueError if a target is not a mapping; `plan` checks whether it fits the scene."""
    try:
        target = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ValueError(f'target: {text!r} is not YAML: {error}') from None
    if not isinstance(target, dict) or not {*KINDS} & {*target}:
        raise ValueError(
            "target must be such as {pot: '8', pocket: any}, with one of the keys "
            f'{", ".join(KINDS)}, got {text!r}'
        )


PLANNER = (
    TABLE_FRAME,
    NodeParameter(
        'scene',
        'paper',
        'Table, balls until table_state has been received, robot and noise: name of a bundled '
        'scene, or path of a YAML file.',
        check=Scene.load,
    ),
    NodeParameter(
        'target',
        '{rest: [0.5, -0.3], radius: 0.1}',
        'Target of the stroke, if the goal does not give one: a YAML mapping, see '
        'docs/planning.md.',
        check=_target,
    ),
    NodeParameter(
        'plan_at_start',
        False,
        'Whether to plan for the target at start-up, with the balls of the scene.',
        read_only=True,
    ),
    NodeParameter(
        'budget',
        60_000,
        'Largest number of simulated strokes, if the goal does not give one.',
        limits=(1, 10_000_000),
    ),
    NodeParameter(
        'time_limit',
        0.0,
        'Time after which a search ends with its best stroke; 0: none.',
        unit='s',
        limits=(0.0, 3600.0),
    ),
    NodeParameter(
        'seed',
        1,
        'Seed of all random numbers, if the goal does not give one.',
        limits=(0, 2**31 - 1),
    ),
    NodeParameter(
        'noise_scale',
        1.0,
        "Factor on the standard deviations of the scene's noise.",
        limits=(0.0, 100.0),
    ),
    NodeParameter(
        'speed_min', 0.1, 'Speed of the slowest stroke.', unit='m/s', limits=(0.001, 20.0)
    ),
    NodeParameter(
        'speed_max', 4.5, 'Speed of the fastest stroke.', unit='m/s', limits=(0.001, 20.0)
    ),
    NodeParameter(
        'elevation_min_deg',
        0.0,
        'Smallest elevation of the cue.',
        unit='degrees',
        limits=(0.0, 90.0),
    ),
    NodeParameter(
        'elevation_max_deg',
        85.0,
        'Largest elevation of the cue.',
        unit='degrees',
        limits=(0.0, 90.0),
    ),
    NodeParameter(
        'azimuth_deg',
        0.0,
        'Middle of the range of directions of strokes, counter-clockwise from +x.',
        unit='degrees',
        limits=(-360.0, 360.0),
    ),
    NodeParameter(
        'azimuth_half_range_deg',
        180.0,
        'Half-width of the range of directions, about `azimuth_deg`.',
        unit='degrees',
        limits=(0.0, 180.0),
    ),
    NodeParameter(
        'offset_max',
        0.5,
        'Largest offset of the tip from the centre of the ball.',
        unit='ball radii',
        limits=(0.001, 0.99),
    ),
)
