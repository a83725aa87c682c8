import dataclasses
import math
import pickle
import re

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.scene import Ball, Cloth, ContactParameters, Cue, Effects
from billiard_shot.scene.errors import InputError
from billiard_shot.scene.files import scene_names
from billiard_shot.scene.player import NOISES
from billiard_shot.scene.scene import PUBLISHED

SHORTEST = """
ball:     {mass: 0.1673, radius: 0.0286}
cue:      {mass: 0.5018, guided: true}
contacts:
  cue_ball: {restitution: 0.656532, friction: 0.4, stiffness: 1.5}
  ball_table: {restitution: 0.51625, friction: 0.152479, stiffness: 1.0}
"""


@pytest.fixture
def data():
    return Scene.load('paper').to_dict()


def test_shortest_form_and_its_defaults(tmp_path):
    path = tmp_path / 'mine.yaml'
    path.write_text(SHORTEST)
    scene = Scene.load(path)
    assert scene == Scene.load(str(path))
    assert scene.law == 'bistiffness'
    assert scene.exponent == 1.0
    assert scene.ball.inertia == pytest.approx(0.4 * 0.1673 * 0.0286**2, rel=1e-15)
    assert scene.cloth == Cloth(0.152479, 0.01, 0.0, 10.0, 9.80665)
    assert scene.effects == Effects()
    assert scene.cue_ball == (0.0, 0.0, 0.0286)


@pytest.mark.parametrize('name', scene_names())
def test_bundled_scenes_survive_a_round_trip(name):
    scene = Scene.load(name)
    assert Scene.from_dict(scene.to_dict()) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene
    assert hash(scene) == hash(Scene.load(name))


def test_guided_cue_has_no_end_mass():
    assert Cue(0.5, guided=True).end_mass == math.inf
    assert Cue(0.5, guided=True).ferrule_radius == 0.0
    assert Cue(0.5).ferrule_radius == 0.0065
    with pytest.raises(ValueError, match=r'end_mass must be omitted for a guided cue, got 0\.005'):
        Cue(0.5, guided=True, end_mass=0.005)
    with pytest.raises(
        ValueError, match=r'end_mass must .*at most the mass of the cue, 0\.5.*, got 0\.6'
    ):
        Cue(0.5, end_mass=0.6)


def test_balls_are_placed(data):
    data['balls'] = {'cue': [0.5, -0.25], 8: [1, 0]}
    scene = Scene.from_dict(data)
    assert scene.cue_ball == (0.5, -0.25, 0.0286)
    assert scene.balls == {'cue': (0.5, -0.25), '8': (1.0, 0.0)}
    assert Scene.from_dict(scene.to_dict()) == scene


def test_yaml_of_people(tmp_path):
    path = tmp_path / 'mine.yaml'
    path.write_text(
        SHORTEST + 'effects: {flight: off, bounce: on}\ncloth: {rolling_resistance: 1e-2}'
    )
    scene = Scene.load(path)
    assert scene.effects == Effects(flight='off', bounce='on')
    assert scene.cloth.rolling_resistance == 0.01


@pytest.mark.parametrize(
    ('section', 'key', 'value', 'allowed'),
    [
        ('ball', 'mass', 0, 'above 0 (kg)'),
        ('ball', 'mass', True, 'a finite number above 0 (kg)'),
        ('ball', 'mass', '0.17', 'a finite number above 0 (kg)'),
        ('ball', 'radius', math.nan, 'above 0 (m)'),
        ('ball', 'radius', math.inf, 'above 0 (m)'),
        ('ball', 'radius', None, 'above 0 (m)'),
        ('ball', 'inertia', 1.0, 'at most 2/3 m r^2'),
        ('cue', 'guided', 'yes', 'true or false'),
        ('cue', 'ferrule_radius', -0.001, 'at least 0 (m)'),
        ('cloth', 'gravity', 0, 'above 0 (m/s^2)'),
        ('cloth', 'spin_deceleration', -1, 'at least 0 (rad/s^2)'),
        ('effects', 'flight', 'maybe', 'one of auto, on, off'),
    ],
)
def test_wrong_value_is_named_with_its_range(data, section, key, value, allowed):
    data[section][key] = value
    allowed, _, unit = allowed.partition(' (')
    unit = f' ({unit}' if unit else ''
    with pytest.raises(ValueError, match='must be') as caught:
        Scene.from_dict(data)
    said = str(caught.value)
    assert said.startswith(f'scene: {section}.{key} must be ')
    assert allowed in said
    assert f', got {value!r}' in said
    assert said.endswith(unit)


@pytest.mark.parametrize(
    ('section', 'values', 'mistakes'),
    [
        ('ball', {'mass': 170}, {'mass': '170 g are 0.17 kg'}),
        ('ball', {'mass': 6}, {'mass': '6 g are 0.006 kg'}),
        ('ball', {'radius': 28.575}, {'radius': '28.575 mm are 0.028575 m'}),
        ('cue', {'mass': 540}, {'mass': '540 g are 0.54 kg'}),
        (
            'cue',
            {'length': 1470, 'ferrule_radius': 6.5, 'tip_curvature_radius': 10.6},
            dict.fromkeys(('ferrule_radius', 'length', 'tip_curvature_radius'), ' mm are '),
        ),
        (
            'table',
            {'length': 2540, 'width': 1270, 'corner': {'mouth': 116, 'radius': 62}},
            dict.fromkeys(('length', 'width', 'corner.mouth', 'corner.radius'), ' mm are '),
        ),
        ('table', {'cushion': {'duration': 5}}, {'cushion.duration': '5 ms are 0.005 s'}),
        ('noise', {'a': 0.5, 'balls': 1}, {'a': '0.5 mm are 0.0005 m', 'balls': '1 mm are 0.001'}),
        ('ball', {'mass': 1e9}, {'mass': r'at most 2, got 1000000000\.0 \(kg\)$'}),
    ],
)
def test_values_in_grams_and_millimetres_are_refused_where_they_stand(
    data, section, values, mistakes
):
    with pytest.raises(InputError) as caught:
        Scene.from_dict(data | {section: data.get(section, {}) | values})
    found = {'.'.join(mistake.path[1:]): mistake.text for mistake in caught.value.mistakes}
    assert found.keys() == mistakes.keys()
    for field, text in mistakes.items():
        assert re.search(text, found[field])


def test_noise_may_have_a_name(data, tmp_path):
    levels = [Scene.from_dict(data | {'noise': name}).noise for name in sorted(NOISES)]
    assert levels == [NOISES[name] for name in sorted(NOISES)]
    weaker = [NOISES[f'fargo_{rating}'].azimuth_deg for rating in (800, 700, 600, 500, 400)]
    assert weaker == sorted(weaker)
    path = tmp_path / 'mine.yaml'
    path.write_text('like: paper\nnoise: fargo_500\n')
    assert Scene.load(path).noise == NOISES['fargo_500']
    path.write_text('like: paper\nnoise: fargo_555\n')
    allowed = r'line 2: noise must be a mapping, or one of .*, got .*the nearest is fargo_500'
    with pytest.raises(InputError, match=allowed):
        Scene.load(path)


@pytest.mark.parametrize(
    ('key', 'value', 'allowed'),
    [
        ('restitution', 1.1, 'at least 0 and at most 1'),
        ('friction', -0.1, 'at least 0'),
        ('stiffness', 0.0, 'above 0'),
    ],
)
def test_wrong_contact_is_named(data, key, value, allowed):
    data['contacts']['cue_ball'][key] = value
    with pytest.raises(ValueError, match=rf'contacts\.cue_ball\.{key} must be .*{allowed}, got'):
        Scene.from_dict(data)
    with pytest.raises(ValueError, match=rf'^{key} must be .*{allowed}, got'):
        ContactParameters(**{**data['contacts']['ball_table'], key: value})


@pytest.mark.parametrize(
    ('contacts', 'text'),
    [
        (
            {'cue_ball': {'stiffness': 1.5}},
            'ball_table.stiffness is missing: cue_ball has a stiffness, so that ball_table must '
            'have one in place of its duration, 0.0007',
        ),
        (
            {'ball_table': {'stiffness': 1.0}},
            'ball_table.duration is missing: cue_ball has a duration, so that ball_table must '
            'have one in place of its stiffness, 1.0',
        ),
        (
            {'cue_ball': {'stiffness': 1.5, 'duration': 0.001}},
            'cue_ball.stiffness must be omitted, because duration is given, got 1.5',
        ),
        (
            {'cue_ball': {'duration': 1.3}},
            'cue_ball.duration must be a finite number above 0 and at most 0.02, got 1.3 (s); '
            '1.3 ms are 0.0013 s',
        ),
    ],
)
def test_a_contact_has_either_a_stiffness_or_a_duration_as_the_other_one_has(contacts, text):
    with pytest.raises(ValueError, match=f'^scene: contacts.{re.escape(text)}$'):
        Scene.from_dict({'like': 'pool', 'contacts': contacts})


def test_a_contact_that_is_neither_stiff_nor_lasting_is_named():
    with pytest.raises(ValueError, match=r'^duration is missing, and so is stiffness'):
        ContactParameters(0.5, 0.2)


def test_a_stiffness_or_a_duration_replaces_what_a_scene_inherits():
    ratio = {'cue_ball': {'stiffness': 2.0}, 'ball_table': {'stiffness': 1.0}}
    pool, paper = Scene.load('pool'), Scene.load('paper')
    contacts = Scene.from_dict({'like': 'pool', 'contacts': ratio}).contacts
    expected = dataclasses.replace(pool.contacts.cue_ball, stiffness=2.0, duration=None)
    assert contacts.cue_ball == expected
    lasting = {'cue_ball': {'duration': 1e-3}, 'ball_table': {'duration': 5e-4}}
    contacts = Scene.from_dict({'like': 'paper', 'contacts': lasting}).contacts
    expected = dataclasses.replace(paper.contacts.ball_table, stiffness=None, duration=5e-4)
    assert contacts.ball_table == expected
    quick = Scene.from_dict({'like': 'pool', 'contacts': {'ball_ball': {'duration': 0}}})
    assert quick.contacts.ball_ball.stiffness == 25.0  # has both


@pytest.mark.parametrize(
    ('key', 'value', 'text'),
    [
        (
            'law',
            'newton',
            'law must be one of bistiffness, energetic, .*, got .newton.',
        ),
        ('exponent', 0.5, 'exponent must be a finite number at least 1 .*, got 0.5'),
        ('exponent', 40, 'exponent must be .*at most 10, got 40'),
        ('balls', {'cue': [0]}, r'balls\.cue must be two finite numbers, .*, got \[0\]'),
        ('balls', [1, 2], r'balls must be a mapping of names to \[x, y\], got \[1, 2\]'),
        ('ball', None, 'ball must be a mapping, got None'),
    ],
)
def test_other_mistakes(data, key, value, text):
    data[key] = value
    with pytest.raises(ValueError, match=text):
        Scene.from_dict(data)


def test_all_mistakes_together():
    with pytest.raises(ValueError, match='scene: 5 mistakes') as caught:
        Scene.from_dict({'ball': {'mass': -1, 'radus': 1}, 'que': {}, 'cue': {'mass': 1}})
    lines = str(caught.value).splitlines()[1:]
    assert len(lines) == 5
    assert lines[0].startswith('  que is unknown; the nearest key is cue')
    assert lines[1] == (
        '  ball.radus is unknown; the nearest key is radius (of mass, radius, inertia)'
    )
    assert lines[2].startswith(
        '  ball.mass must be a finite number above 0 and at most 2, got -1 (kg)'
    )
    assert lines[3:] == ['  ball.radius is missing', '  contacts is missing']


@pytest.mark.parametrize(
    ('text', 'message'),
    [
        ('ball: {mass: 1, mass: 2}', r'line 1: ball\.mass is there twice'),
        ('ball: [', 'line 1'),
        ('just words', 'must be a mapping'),
        ('', 'must be a mapping'),
    ],
)
def test_unreadable_files(tmp_path, text, message):
    path = tmp_path / 'mine.yaml'
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as caught:
        Scene.load(path)
    assert str(path) in str(caught.value)


def test_scenes_that_are_not_there(tmp_path):
    with pytest.raises(
        ValueError, match=r"scene must be one of .*, got 'papre'; the nearest is paper"
    ):
        Scene.load('papre')
    with pytest.raises(ValueError, match='No such file'):
        Scene.load(tmp_path / 'none.yaml')
    with pytest.raises(ValueError, match='directory'):
        Scene.load(tmp_path)


def test_frozen_and_replaceable():
    scene = Scene.load('pool')
    with pytest.raises(dataclasses.FrozenInstanceError):
        scene.law = 'energetic'
    assert dataclasses.replace(scene, law='energetic').law == 'energetic'
    with pytest.raises(ValueError, match='ball must be a Ball, got 3'):
        dataclasses.replace(scene, ball=3)
    with pytest.raises(ValueError, match=r'mass must .*\n.*radius must '):
        Ball(0.0, -1.0)


def test_a_name_is_accepted_wherever_a_scene_is():
    from billiard_shot import (
        BallState,
        invert_strike,
        plan,
        predict,
        predict_batch,
        simulate,
        simulate_batch,
        Stroke,
    )

    scene = Scene.load('pool_table')
    assert Scene.load(scene) is scene
    assert 'pool_table' in Scene.names()
    stroke = Stroke.from_offsets(b=0.1, elevation_deg=6, speed=1)
    rows, moving = (
        ([stroke.normal], [stroke.velocity]),
        {'cue': BallState((0, 0, 0.0286), (1, 0, 0))},
    )
    assert predict('pool_table', stroke).message == predict(scene, stroke).message
    for call, *arguments in (
        (predict_batch, *rows),
        (simulate, moving),
        (simulate_batch, [moving]),
        (plan, {'pass': (0.5, 0)}, 'none', 100),
    ):
        assert call('pool_table', *arguments).status == call(scene, *arguments).status
    wanted = (1.0, 0.0, 0.0), (0.0, 20.0, 0.0)
    assert (
        invert_strike('pool', *wanted).stroke == invert_strike(Scene.load('pool'), *wanted).stroke
    )
    with pytest.raises(ValueError, match=r'scene must be a Scene, .*, got 7'):
        predict(7, stroke)


# --- the numbers of scenes by name: read, changed, and refused -----------------------------------

SCENE = Scene.load('pool_table')


def test_parameters_have_values_units_bounds_and_published_ranges():
    names = 'cloth.rolling_resistance', 'contacts.ball_ball.restitution', 'table.cushion.height'
    rolling, balls, height = SCENE.parameters(names)
    assert (rolling.name, rolling.value) == (names[0], SCENE.cloth.rolling_resistance)
    assert rolling.published == (0.005, 0.015)
    assert (rolling.low, rolling.high) == (0.0, 1.0)
    assert (balls.low, balls.high, balls.published) == (0.0, 1.0, (0.92, 0.98))
    assert (height.unit, height.low, height.high) == ('ball diameters', 0.5, 0.95)
    (mass,) = SCENE.parameters(['ball.mass'])
    assert (mass.unit, mass.low) == ('kg', 0.0)


def test_contacts_have_a_stiffness_or_a_duration_among_their_numbers():
    for name, given, lacking in (
        ('pool', 'duration', 'stiffness'),
        ('paper', 'stiffness', 'duration'),
    ):
        listed = [each.name for each in Scene.load(name).parameters()]
        assert f'contacts.ball_table.{given}' in listed
        assert f'contacts.ball_table.{lacking}' not in listed
    name = 'contacts.cue_ball.duration'
    (tip,) = SCENE.with_parameters([name], [0.9e-3]).parameters([name])
    assert (tip.value, tip.unit, tip.published) == (0.9e-3, 's', (0.8e-3, 3e-3))


def test_all_numbers_are_listed_once_and_lie_within_their_bounds():
    for name in Scene.names():
        listed = Scene.load(name).parameters()
        names = [each.name for each in listed]
        assert len(set(names)) == len(names)
        assert 'cue.mass' in names
        sections = 'robot', 'noise', 'model_error', 'effects'
        assert not any(each.startswith(sections) for each in names)
        assert ('table.width' in names) == (Scene.load(name).table is not None)
        for each in listed:
            assert each.low <= each.value <= each.high
            assert each.published is None or each.published[0] < each.published[1]


def test_published_ranges_have_sources_and_hold_the_numbers_of_pool():
    known = {each.name: each for each in SCENE.parameters()}
    assert set(PUBLISHED) <= set(known)
    for name in PUBLISHED:
        each = known[name]
        low, high = each.published
        assert each.source
        point = name == 'cue.tip_curvature_radius' and each.value == 0.0  # not a rounded tip
        assert point or low <= each.value <= high, name


def test_other_numbers_make_another_scene():
    names = ['table.cushion.restitution', 'cloth.rolling_resistance', 'ball.mass']
    other = SCENE.with_parameters(names, [0.7, 0.02, 0.2])
    assert [each.value for each in other.parameters(names)] == [0.7, 0.02, 0.2]
    assert other.ball.inertia == pytest.approx(0.4 * 0.2 * SCENE.ball.radius**2)  # follows
    assert other.balls == SCENE.balls
    back = other.with_parameters(names, [each.value for each in SCENE.parameters(names)])
    assert [each.value for each in back.parameters()] == [
        each.value for each in SCENE.parameters()
    ]
    assert SCENE.with_parameters([], []) == SCENE


def test_wrong_names_and_values_are_refused():
    with pytest.raises(ValueError, match=r'parameters: table.cushion.restition is unknown; '):
        SCENE.parameters(['table.cushion.restition'])
    with pytest.raises(ValueError, match=r'nearest key is table.cushion.restitution'):
        SCENE.with_parameters(['table.cushion.restition'], [0.7])
    with pytest.raises(ValueError, match=r'table.cushion.restitution'):
        SCENE.with_parameters(['table.cushion.restitution'], [1.7])
    with pytest.raises(ValueError, match=r'values must be of shape \(1,\), got \(2,\)'):
        SCENE.with_parameters(['ball.mass'], np.ones(2))
    with pytest.raises(ValueError, match=r'table.width is unknown'):
        Scene.load('pool').parameters(['table.width'])
