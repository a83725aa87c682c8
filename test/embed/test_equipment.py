"""What a page can change in a scene: its changes are what Python makes of the changed scene."""

from copy import deepcopy
import dataclasses

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.embed.page_state import equipment_of
from billiard_shot.embed.scenes import export_scene, packed_play, plain
from billiard_shot.scene.scene import with_parameters


def changed(arguments, equipment, effects, parameters):
    """Change arguments of `play_tables` as a page does."""
    made = deepcopy(arguments)

    def put(path, value):
        place = made
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value

    for each in equipment['parameters']:
        for path in each['paths'] if each['name'] in parameters else ():
            put(path, parameters[each['name']])
    for name in effects:
        for path, value in equipment['effects'][name]['change']:
            put(path, value)
    return made


@pytest.mark.parametrize('name', ['nine_ball', 'paper', 'carom', 'snooker', 'frozen_combination'])
def test_changes_are_those_of_the_changed_scene(name):
    scene, draw = Scene.load(name), np.random.default_rng(3)
    equipment = equipment_of(scene)
    base = plain(packed_play(scene))
    assert len(equipment['effects']) > 10
    assert len(equipment['parameters']) > 10
    for _ in range(12):
        effects = [each for each in equipment['effects'] if draw.random() < 0.3]
        numbers = [each for each in equipment['parameters'] if draw.random() < 0.5]
        parameters = {each['name']: float(draw.uniform(*each['range'])) for each in numbers}
        other = with_parameters(scene, list(parameters), list(parameters.values()))
        on = equipment['effects']
        turned = {each: 'off' if on[each]['on'] else 'auto' for each in effects}
        settings = dataclasses.replace(other.effects, **turned)
        expected = plain(packed_play(dataclasses.replace(other, effects=settings)))
        assert changed(base, equipment, effects, parameters) == expected


def test_a_number_that_is_derived_follows_after_one_that_is_given():
    """The sliding friction is that of the cloth, unless it is given, even as the same number."""
    derived = Scene.load('nine_ball')
    given = with_parameters(derived, ['cloth.sliding_friction'], [derived.cloth.sliding_friction])
    assert given == derived

    def paths(scene):
        offered = equipment_of(scene)['parameters']
        return next(x['paths'] for x in offered if x['name'] == 'contacts.ball_table.friction')

    sliding = 'layout', 'params', 'sliding_friction'
    assert sliding not in paths(given)
    assert sliding in paths(derived)


def test_an_effect_that_is_off_can_be_turned_on():
    scene = Scene.from_dict({'like': 'pool_table', 'effects': {'throw': 'off'}})
    throw = equipment_of(scene)['effects']['throw']
    assert not throw['on']
    auto = plain(packed_play(Scene.load('pool_table')))
    made = changed(plain(packed_play(scene)), equipment_of(scene), ['throw'], {})
    assert made['layout'] == auto['layout']


def test_values_to_offer_are_allowed_and_around_that_of_the_scene():
    scene = Scene.load('pool_table')
    for each in equipment_of(scene)['parameters']:
        low, high = each['range']
        assert low <= each['value'] <= high
        for value in (low, high):
            with_parameters(scene, [each['name']], [value])


def test_a_scene_whose_cushions_are_off_has_no_pockets_for_a_page():
    scene = Scene.from_dict({'like': 'pool_table', 'effects': {'cushion': 'off'}})
    exported = export_scene(scene)
    assert exported['pockets'] == ()
    assert 'find_direct_shots' not in exported['entries']
