"""Parameters of the planner's node."""

import yaml

from billiard_shot.planning.targets import KINDS
from billiard_shot.ros.parameters import Parameter, TABLE_FRAME
from billiard_shot.scene import Scene


def _target(text: str) -> None:
    """Raise ValueError where a target is no mapping; whether it fits the scene, `plan` says."""
    try:
        target = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ValueError(f'target: {text!r} is not YAML: {error}') from None
    if not isinstance(target, dict) or not {*KINDS} & {*target}:
        raise ValueError(
            f"target: {text!r} is not allowed; it must be such as {{pot: '8', pocket: any}}, with "
            f'one of the keys {", ".join(KINDS)}'
        )


PLANNER = (
    TABLE_FRAME,
    Parameter(
        'scene',
        'blocked',
        'Table, balls until table_state has come in, and who plays: name of a bundled scene, or '
        'path of a YAML file.',
        check=Scene.load,
    ),
    Parameter(
        'target',
        "{pot: '8', pocket: any}",
        'What the stroke has to reach where a goal does not say: a YAML mapping, see '
        'docs/planning.md.',
        check=_target,
    ),
    Parameter(
        'plan_at_start',
        False,
        'Whether to plan for the target as the node starts, with the balls of the scene.',
    ),
    Parameter(
        'budget',
        20_000,
        'Most strokes that are simulated where a goal does not say.',
        limits=(1, 10_000_000),
    ),
    Parameter(
        'seed',
        1,
        'Of all that is random where a goal does not say.',
        limits=(0, 2**31 - 1),
    ),
    Parameter(
        'noise_times',
        1.0,
        "Factor on the standard deviations of the scene's noise.",
        limits=(0.0, 100.0),
    ),
    Parameter('speed_min', 0.1, 'Slowest stroke.', unit='m/s', limits=(0.001, 20.0)),
    Parameter('speed_max', 4.5, 'Fastest stroke.', unit='m/s', limits=(0.001, 20.0)),
    Parameter(
        'elevation_min_deg',
        0.0,
        'Least elevation of the cue.',
        unit='degrees',
        limits=(0.0, 90.0),
    ),
    Parameter(
        'elevation_max_deg',
        85.0,
        'Largest elevation of the cue.',
        unit='degrees',
        limits=(0.0, 90.0),
    ),
    Parameter(
        'azimuth_deg',
        0.0,
        'Middle of the directions of strokes, counter-clockwise from +x.',
        unit='degrees',
        limits=(-360.0, 360.0),
    ),
    Parameter(
        'azimuth_range_deg',
        180.0,
        'How far they reach to each side of it.',
        unit='degrees',
        limits=(0.0, 180.0),
    ),
    Parameter(
        'offset_max',
        0.5,
        'Largest distance of the tip from the middle of the ball.',
        unit='ball radii',
        limits=(0.001, 0.99),
    ),
)
