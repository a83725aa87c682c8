"""A scene for the JavaScript module (web/core.mjs): all that depends on it, as JSON."""

import math
from typing import Any

from billiard_shot import machine_code
from billiard_shot.embed.packed import packed_scene
from billiard_shot.embed.plain import plain
from billiard_shot.numerics import rounding
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.player import MIN_NOISY_SPEED, OFFSETS
from billiard_shot.scene.values import LARGEST
from billiard_shot.shot.accuracy import DEFAULT_SHOT_TOLERANCE
from billiard_shot.shot.setting import setting_of
from billiard_shot.shot.stroke import SPEED_RANGE
from billiard_shot.table.geometry import layout_of
from billiard_shot.table.rolling_boundary import HOLES
from billiard_shot.table.run import cushion_name, POCKET_NAMES


def export_scene(scene: SceneLike, tolerance: float = DEFAULT_SHOT_TOLERANCE) -> dict[str, Any]:
    """
    Export a scene for pages that play strokes in it.

    Parameters
    ----------
    scene : Scene, str or Path
    tolerance : float
        Largest error of the trajectories [m].

    Returns
    -------
    dict
        For `json.dumps`. It belongs to the version of the compiled core that this package has.

    """
    scene = Scene.load(scene)
    setting, radius = setting_of(scene), float(scene.ball.radius)
    layout = layout_of(setting.model.surface, setting.table)
    numbers = layout.numbers
    beyond = numbers.cushion_depth
    return {
        'sources': machine_code.sources(),
        'names': setting.names,
        'places': {
            name: place[:2]
            for name, place in zip(
                setting.names, setting.starts['position'][0].tolist(), strict=True
            )
        },
        'pockets': POCKET_NAMES if layout.pockets else (),
        'cushions': [cushion_name(feature) for feature in range(HOLES)],
        'radius': radius,
        'apart': (2.0 * radius - rounding.PLACE, 2.0 * LARGEST, 'm'),
        'ranges': {
            'a': (-LARGEST, LARGEST, 'ball radii'),
            'b': (-LARGEST, LARGEST, 'ball radii'),
            'elevation': (-0.5 * math.pi, 0.5 * math.pi, 'rad'),
            'azimuth': (-2.0 * math.pi, 2.0 * math.pi, 'rad'),
            'speed': (*SPEED_RANGE, 'm/s'),
            'x': _range(numbers.nose_half_length + beyond),
            'y': _range(numbers.nose_half_width + beyond),
        },
        'noise': dict(zip(OFFSETS, scene.noise.sigmas(radius).tolist(), strict=True)),
        'slowest': MIN_NOISY_SPEED,
        'entries': {
            entry.function.__name__: plain(arguments)
            for entry, arguments in packed_scene(scene, tolerance).items()
        },
    }


def _range(half: float) -> tuple[float, float, str]:
    half = min(half, LARGEST)
    return -half, half, 'm'
