"""A scene for the JavaScript module (web/core.mjs): all that depends on it, as JSON."""

import math
from typing import Any

import numpy as np

from billiard_shot import machine_code
from billiard_shot.embed.packed import packed_scene
from billiard_shot.numerics import rounding
from billiard_shot.scene import Scene, SceneLike
from billiard_shot.scene.player import MIN_NOISY_SPEED, OFFSETS
from billiard_shot.scene.values import LARGEST
from billiard_shot.shot.setting import setting_of
from billiard_shot.shot.stroke import SPEED_RANGE
from billiard_shot.table.geometry import layout_of
from billiard_shot.table.run import POCKET_NAMES


def export_scene(scene: SceneLike) -> dict[str, Any]:
    """
    Export a scene for pages that play strokes in it.

    Parameters
    ----------
    scene : Scene, str or Path

    Returns
    -------
    dict
        For `json.dumps`. It belongs to the version of the compiled core that this package has.

    """
    scene = Scene.load(scene)
    setting, radius = setting_of(scene), float(scene.ball.radius)
    numbers = layout_of(setting.model.surface, setting.table).numbers
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
        'pockets': POCKET_NAMES if scene.table is not None and scene.table.pockets else (),
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
            entry.function.__name__: _plain(arguments)
            for entry, arguments in packed_scene(scene).items()
        },
    }


def _range(half: float) -> tuple[float, float, str]:
    half = min(half, LARGEST)
    return -half, half, 'm'


def _plain(value: Any) -> Any:
    """Return arguments as JSON has them; arrays of zeros as their shapes."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value).replace('inf', 'Infinity')  # JSON has none; this is one in JavaScript
    if isinstance(value, dict):
        return {name: _plain(each) for name, each in value.items()}
    if hasattr(value, '_asdict'):
        return _plain(value._asdict())
    if not isinstance(value, np.ndarray):
        return value
    if not any(value.tobytes()):
        return {'shape': value.shape}
    rows, names = value.ravel().tolist(), value.dtype.names
    if names:
        rows = [dict(zip(names, map(_field, row), strict=True)) for row in rows]
    return {'shape': value.shape, 'values': [_plain(row) for row in rows]}


def _field(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray) else value
