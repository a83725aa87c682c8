"""The state of a page (pictures/page/state.js) as a scene, a stroke and a noise."""

from collections.abc import Mapping
import dataclasses
import math
from typing import Any

from billiard_shot.scene import Noise, Scene
from billiard_shot.scene.placement import CUE_BALL
from billiard_shot.scene.player import OFFSETS
from billiard_shot.shot.shot import Shot
from billiard_shot.shot.stroke import Stroke

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
