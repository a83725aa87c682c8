"""The state of a page, and the changes of the equipment that it offers."""

from collections.abc import Iterator, Mapping
import dataclasses
from functools import lru_cache
import math
from typing import Any

from billiard_shot.embed.scenes import packed_play, plain
from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import OFFSETS
from billiard_shot.scene.scene import Parameter, parameters_of, with_parameters
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke

Path = tuple[str | int, ...]
TRIED = 0.3, 0.7  # parts of the range of a number at which its entries are looked for
LEFT_OUT = 'm', 's', 'N/m', 'any unit'  # a page draws lengths; effects use springs in other ways
LARGEST_RATIO = 4.0  # between the bounds of a range and a value without published ones


def equipment_of(scene: Scene) -> dict[str, Any]:
    """
    List what a page can change in a scene.

    Returns
    -------
    dict
        `effects`, by name: whether a shot simulates it if it is called for (`on`), and the
        `change` that turns it off, or on. `parameters`: `name`, `value` and `unit` of each number,
        the bounds of values to offer (`range`), and the `paths` of its entries.

    """
    alone = dataclasses.replace(scene, balls={CUE_BALL: scene.cue_ball[:2]})
    return _equipment(alone, str(alone.to_dict()))


@lru_cache(maxsize=16)
def _equipment(scene: Scene, _: str) -> dict[str, Any]:
    """Scenes with equal numbers may differ in which of them are derived: their text tells."""
    base = plain(packed_play(scene))
    offered = [
        (each, paths)
        for each in parameters_of(scene)
        if each.unit not in LEFT_OUT and (paths := _paths(scene, base, each))
    ]
    # an effect may set a number that the scene has so already
    names = [each.name for each, _ in offered]
    other = with_parameters(
        scene, names, [_between(_range(each), TRIED[0]) for each, _ in offered]
    )
    parameters = [
        {
            'name': each.name,
            'value': each.value,
            'unit': each.unit,
            'range': _range(each),
            'paths': paths,
        }
        for each, paths in offered
    ]
    return {'effects': _effects([other, scene]), 'parameters': parameters}


def _effects(scenes: list[Scene]) -> dict[str, Any]:
    """
    List effects; a change has the entries that it sets in one of the scenes.

    Effects that are off come first. Some need another effect, as the shear of a tip needs the
    shaft: if a page turns the shaft off, the change of the shaft also ends the shear.
    """
    settings, found = dataclasses.asdict(scenes[0].effects), {}
    names = sorted(settings, key=lambda name: settings[name] != 'off')
    turned_on = {name: 'auto' for name in names if settings[name] == 'off'}
    all_on = dataclasses.replace(scenes[1].effects, **turned_on)
    others = (dataclasses.replace(scenes[1], effects=all_on), *scenes)
    bases = [(scene, plain(packed_play(scene))) for scene in others]
    for name in names:
        on = name not in turned_on
        change: dict[Path, Any] = {}
        for scene, base in bases:
            effects = dataclasses.replace(scene.effects, **{name: 'off' if on else 'auto'})
            other = dataclasses.replace(scene, effects=effects)
            change |= dict(_changes(base, plain(packed_play(other))))
        if change:
            found[name] = {'on': on, 'change': list(change.items())}
    return found


def _range(number: Parameter) -> tuple[float, float]:
    """Choose bounds of the values to offer: twice as far apart as published ones."""
    value = number.value
    low, high = value / LARGEST_RATIO, value * LARGEST_RATIO
    if number.published:
        low, high = min(number.published[0], value), max(number.published[1], value)
        low, high = 1.5 * low - 0.5 * high, 1.5 * high - 0.5 * low
    return max(number.low, low), min(number.high, high)


def _between(bounds: tuple[float, float], part: float) -> float:
    low, high = bounds
    return low + part * (high - low)


def _paths(scene: Scene, base: Any, number: Parameter) -> list[Path]:
    """Find the entries that are a number of the scene; none if one depends on it otherwise."""
    found: list[list[Path]] = []
    for part in TRIED:
        value = _between(_range(number), part)
        try:
            changed = with_parameters(scene, [number.name], [value])
        except ValueError:  # it does not go together with another number
            return []
        changes = list(_changes(base, plain(packed_play(changed))))
        if any(new != value for _, new in changes):
            return []
        found.append([path for path, _ in changes])
    return found[0] if found[0] == found[1] else []


def _changes(before: Any, after: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield path and new value of each entry that differs."""
    if before == after:
        return
    if isinstance(before, dict) and isinstance(after, dict) and before.keys() == after.keys():
        keys: Any = before
    elif isinstance(before, list) and isinstance(after, list) and len(before) == len(after):
        keys = range(len(before))
    else:
        yield path, after
        return
    for key in keys:
        yield from _changes(before[key], after[key], (*path, key))


State = Mapping[str, Any]


def check_form(state: Any) -> None:
    """Check the form of a state that came from elsewhere; ValueError naming what is wrong."""
    if not isinstance(state, Mapping):
        raise ValueError(f'state must be an object, got {state!r}')
    names = state.get('effects', [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ValueError(f'state.effects must be a list of names, got {names!r}')
    for field in ('parameters', 'noise'):
        numbers = state.get(field, {})
        if not isinstance(numbers, Mapping) or not all(
            isinstance(number, int | float) for number in numbers.values()
        ):
            raise ValueError(f'state.{field} must have a number by each name, got {numbers!r}')


def scene_in(state: State, scene: Scene) -> Scene:
    """
    Copy the scene of a page with the balls, effects and numbers of a state.

    Raises
    ------
    ValueError
        Naming what is wrong in the state.

    """
    data = scene.to_dict()
    data['balls'] = state.get('balls', data['balls'])
    for name in state.get('effects', ()):
        off = getattr(scene.effects, name, 'off') == 'off'
        data['effects'][name] = 'auto' if off else 'off'
    numbers = state.get('parameters', {})
    return Scene.from_dict(data).with_parameters(list(numbers), list(numbers.values()))


def stroke_in(state: State) -> Stroke:
    """Read the stroke of a state; ValueError if it is not one."""
    stroke = state['stroke']
    if 'normal' in stroke:
        return Stroke(stroke['normal'], stroke['velocity'])
    return Stroke.from_offsets(**{name: stroke[name] for name in OFFSETS})


def noise_in(state: State, scene: Scene) -> Noise:
    """Read the errors of the player; ValueError if one is out of range."""
    sigmas, radius = state.get('noise', {}), scene.ball.radius
    units = {'a': radius, 'b': radius, 'speed': 1.0}
    errors = {name: sigmas[name] * unit for name, unit in units.items() if name in sigmas}
    for name in ('elevation', 'azimuth'):
        if name in sigmas:
            errors[f'{name}_deg'] = math.degrees(sigmas[name])
    return dataclasses.replace(scene.noise, **errors)


def start_of(shot: Shot) -> dict[str, Any]:
    """Write a shot as a part of a state: where the balls lie, and the stroke."""
    balls = {**shot.scene.balls, CUE_BALL: tuple(shot.position[:2].tolist())}
    return {'balls': balls, **played(shot.scene, shot.stroke)}


def played(scene: Scene, stroke: Stroke) -> dict[str, Any]:
    """Write a stroke as a part of a state."""
    stroke = stroke.touching(scene.cue.tip_curvature_radius / scene.ball.radius)
    # the vectors, too: made of the offsets, they could differ in the last bit
    vectors = {'normal': stroke.normal, 'velocity': stroke.velocity}
    offsets = dict(zip(OFFSETS, stroke.offsets, strict=True))
    return {'stroke': offsets | vectors, 'level': offsets['elevation']}
