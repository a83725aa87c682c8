"""Strokes as people write them down: a YAML list, each in one of the three forms of `Stroke`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from billiard_shot.scene.errors import refused, unknown
from billiard_shot.scene.player import IN_DEGREES
from billiard_shot.scene.yaml_file import read_yaml
from billiard_shot.shot.stroke import Stroke

FORMS: tuple[tuple[str, ...], ...] = (
    ('normal', 'velocity'),
    IN_DEGREES,  # all but the speed are 0 by default
    ('position', 'quaternion', 'speed'),
)


def read_strokes(path: Path, ball: tuple[float, float, float]) -> dict[str, Stroke]:
    """
    Read named strokes from a YAML file.

    Parameters
    ----------
    path : Path
        Of a list of mappings, each with the keys of one of `FORMS` and perhaps a `name`.
    ball : (3,) tuple of float
        Centre of the cue ball [m], for strokes that are stated as a pose.

    Raises
    ------
    ValueError
        Listing every mistake in the file.

    """
    data = read_yaml(path)
    if not isinstance(data, list) or not data:
        raise ValueError(f'{path} must hold a list of strokes, such as [{{a: 0.2, speed: 1.5}}]')
    strokes: dict[str, Stroke] = {}
    mistakes = []
    for number, entry in enumerate(data, 1):
        name = str(entry.get('name', number)) if isinstance(entry, Mapping) else str(number)
        if name in strokes:
            mistakes.append(f'stroke {number}: name {name!r} is there twice')
        try:
            strokes[name] = stroke_from(entry, ball)
        except ValueError as mistake:
            is_mapping = isinstance(entry, Mapping)
            mistakes.append(f'stroke {name}{":" if is_mapping else ""} {mistake}')
    if mistakes:
        raise ValueError('\n  '.join([f'{path}: {len(mistakes)} wrong', *mistakes]))
    return strokes


def stroke_from(entry: object, ball: tuple[float, float, float]) -> Stroke:
    """Make one stroke of a mapping with the keys of one of `FORMS`, and perhaps a `name`."""
    if not isinstance(entry, Mapping):
        raise refused(entry, 'a mapping')
    given: dict[str, Any] = {str(key): value for key, value in entry.items() if key != 'name'}
    known = sorted({key for form in FORMS for key in form})
    for key in given:
        if key not in known:
            raise ValueError(f'{key} {unknown(key, known)}')
    if given.keys() == {'normal', 'velocity'}:
        return Stroke(**given)
    if given.keys() == {'position', 'quaternion', 'speed'}:
        return Stroke.from_pose(**given, ball=ball)
    if given and given.keys() <= set(FORMS[1]):
        return Stroke.from_offsets(**given)
    for form in (FORMS[0], FORMS[2]):
        if given and given.keys() <= set(form):
            raise ValueError(f'{next(key for key in form if key not in given)} is missing')
    raise ValueError(
        f'keys must be those of one form, {"; or ".join(", ".join(form) for form in FORMS)}, got '
        + ', '.join(given)
    )
