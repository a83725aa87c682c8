"""Every mistake in a scene, each once, all together, with its line."""

import copy
import dataclasses
import math
from pathlib import Path
import pickle
import re

from hypothesis import given
from hypothesis import strategies as st
import pytest
import yaml

from billiard_shot.cli import main
from billiard_shot.scene import Ball, Cloth, Cue, Scene
from billiard_shot.scene.errors import InputError
from billiard_shot.scene.files import scene_names

BAD = """\
ball:
  mass: -0.17
  radus: 0.0286
  radius: 0.0286
cue:
  mass: 0.5
  mass: 0.6
  guided: yes please
contacts:
  cue_ball: {restitution: 1.5, friction: 0.4, stiffness: 1.5}
  ball_table: {restitution: 0.5, friction: 0.15}
effects:
  flight: sometimes
  teleport: on
balls:
  cue: [0, 0]
  8: [0.05, 0]
  '8': [1, 1]
  7: [0.5, x]
"""
LINES = {
    'ball.mass': 2,
    'ball.radus': 3,
    'cue.mass': 7,
    'cue.guided': 8,
    'contacts.cue_ball.restitution': 10,
    'contacts.ball_table.duration': 11,
    'effects.flight': 13,
    'effects.teleport': 14,
    'balls.8': 17,
    'balls.7': 19,
}


@pytest.fixture
def bad(tmp_path):
    path = tmp_path / 'bad.yaml'
    path.write_text(BAD)
    return path


def test_all_mistakes_with_their_lines(bad):
    with pytest.raises(InputError) as caught:
        Scene.load(bad)
    found = [(mistake.line, '.'.join(mistake.path)) for mistake in caught.value.mistakes]
    assert found == sorted([*((line, key) for key, line in LINES.items()), (18, 'balls.8')])
    text = str(caught.value)
    assert text.startswith(
        f'scene {bad}: 11 mistakes\n'
        '  line 2: ball.mass must be a finite number above 0 and at most 2, got -0.17'
    )
    assert 'the nearest key is radius' in text
    assert 'no position' not in text
    assert 'line 7: cue.mass is there twice, first in line 6' in text
    assert 'line 11: contacts.ball_table.duration is missing, and so is stiffness' in text
    assert (
        "line 17: balls.8 must be at least 57.2 mm from ball 'cue', which it overlaps by 7.2 mm"
        in text
    )


def test_the_same_from_a_mapping_without_lines():
    data = yaml.safe_load(BAD.replace("  '8': [1, 1]\n", '').replace('  mass: 0.6\n', ''))
    with pytest.raises(InputError) as caught:
        Scene.from_dict(data)
    assert {'.'.join(m.path) for m in caught.value.mistakes} == LINES.keys() - {'cue.mass'}
    assert all(mistake.line is None for mistake in caught.value.mistakes)
    assert 'line' not in str(caught.value)


def test_names_that_differ_only_in_yaml():
    data = Scene.load('pool').to_dict()
    with pytest.raises(ValueError, match=r'^scene: balls\.8 is there twice$'):
        Scene.from_dict({**data, 'balls': {8: [0.3, 0.3], '8': [0.5, 0.5]}})


def test_overlap_with_a_cue_ball_that_is_not_placed():
    data = Scene.load('pool').to_dict()
    with pytest.raises(
        ValueError, match=r"from ball 'cue', which it overlaps by 37.2 mm, got .* has no position"
    ):
        Scene.from_dict({**data, 'balls': {'1': [0.02, 0]}})
    with pytest.raises(ValueError, match=r"^balls\.1 must be .* from ball 'cue', which it"):
        dataclasses.replace(Scene.load('pool'), balls={'1': (0.02, 0)})
    touching = {'1': (2 * 0.028575, 0), '2': (-2 * 0.028575 * (1 - 1e-15), 0)}
    assert len(Scene.from_dict({**data, 'balls': touching}).balls) == 2


def test_every_pair_that_overlaps_once():
    data = Scene.load('pool').to_dict()
    heap = {name: [0.5 + 0.001 * i, 0] for i, name in enumerate('abcd')}
    with pytest.raises(InputError) as caught:
        Scene.from_dict({**data, 'balls': heap})
    assert len(caught.value.mistakes) == 6


def test_rules_wait_for_the_fields_they_need():
    """A wrong radius says nothing of overlaps, of the inertia or of anything else."""
    data = Scene.load('pool').to_dict()
    data |= {'ball': {'mass': 0.17, 'radius': -1, 'inertia': 7}, 'balls': {'1': [0, 0]}}
    with pytest.raises(InputError) as caught:
        Scene.from_dict(data)
    assert [mistake.path for mistake in caught.value.mistakes] == [('ball', 'radius')]


def test_derived_values_follow():
    ball = Ball(0.2, 0.03)
    assert dataclasses.replace(ball, mass=0.4).inertia == pytest.approx(0.4 * 0.4 * 0.03**2)
    given_one = Ball(0.2, 0.03, inertia=5e-5)
    assert dataclasses.replace(given_one, mass=0.4).inertia == 5e-5
    assert dataclasses.replace(Cue(0.5), guided=True).end_mass == math.inf
    assert dataclasses.replace(Cue(0.5, guided=True), guided=False).ferrule_radius == 0.0065
    assert dataclasses.replace(Cue(0.5), mass=0.001).end_mass == 0.001
    with pytest.raises(ValueError, match=r'end_mass must be omitted for a guided cue, got 0\.005'):
        dataclasses.replace(Cue(0.5, end_mass=0.005), guided=True)


@pytest.mark.parametrize(
    'duplicate',
    [
        lambda scene: scene,
        copy.deepcopy,
        lambda scene: pickle.loads(pickle.dumps(scene)),
        lambda scene: Scene.from_dict(scene.to_dict()),
    ],
)
def test_derived_values_follow_across_sections(duplicate):
    scene = duplicate(Scene.load('pool'))
    contact = dataclasses.replace(scene.contacts.ball_table, friction=0.3)
    changed = dataclasses.replace(
        scene, contacts=dataclasses.replace(scene.contacts, ball_table=contact)
    )
    assert changed.cloth.sliding_friction == 0.3
    fixed = dataclasses.replace(scene, cloth=Cloth(sliding_friction=0.2))
    assert dataclasses.replace(fixed, contacts=changed.contacts).cloth.sliding_friction == 0.2
    moved = dataclasses.replace(changed, cloth=dataclasses.replace(changed.cloth, gravity=1.6))
    assert moved.cloth == Cloth(0.3, gravity=1.6)


@given(st.floats(1e-3, 2.0), st.floats(1e-3, 0.5), st.floats(1e-3, 2.0))
def test_a_replaced_ball_is_a_new_ball(mass, radius, other):
    assert dataclasses.replace(Ball(mass, radius), mass=other) == Ball(other, radius)


def test_command(bad, tmp_path, capsys):
    assert main(['scene', 'check', str(bad)]) == 1
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith(f'{bad}: 11 mistakes\n  line 2: ball.mass must be ')
    assert main(['scene', 'check', 'paper', str(bad), str(tmp_path / 'none.yaml'), 'pool']) == 1
    out, err = capsys.readouterr()
    assert [line.split(':')[0] for line in out.splitlines()] == ['paper', 'pool']
    assert 'No such file' in err
    assert main(['scene', 'check', *scene_names()]) == 0


@pytest.mark.parametrize('name', scene_names())
def test_shown_scenes_can_be_read(name, tmp_path, capsys):
    assert main(['scene', 'show', name]) == 0
    path = tmp_path / 'shown.yaml'
    path.write_text(capsys.readouterr().out)
    assert Scene.load(path) == Scene.load(name)


def test_bundled_scenes_say_what_they_are(capsys):
    assert main(['scene', 'list']) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines if line[0] != ' '] == scene_names()
    assert all(len(line.split()) > 4 for line in lines if line[0] != ' ')


@pytest.mark.parametrize(
    ('text', 'line'),
    [
        ('ball: &b {mass: -1, radius: 0.1}\ncue: *b', 1),
        ('ball: {mass: 1, radius: 0.1}\ncue:\n  <<: {mass: -2}\n', 2),
        ('? [1]\n: 2\n', 1),
        ('ball: &x [*x]\n', 1),
    ],
)
def test_odd_yaml_is_no_trap(tmp_path, text, line):
    path = tmp_path / 'odd.yaml'
    path.write_text(text)
    with pytest.raises(ValueError, match=f'line {line}'):
        Scene.load(path)


@pytest.mark.parametrize(
    ('place', 'right'),
    [
        ((1.2424, 0.3), True),
        ((1.2425, 0.3), False),
        ((0.3, -0.6074), True),
        ((0.3, -0.6075), False),
        ((3, 3), False),
        # in the mouth of a pocket: between the jaws, and not yet over the hole
        ((0, 0.638), True),
        ((0, 0.641), False),
        ((0.03, 0.638), True),
        ((0.04, 0.638), False),
        ((1.2414, 0.6064), True),
        ((-1.25, 0.61), True),
        ((-1.26, -0.63), False),
        ((1.23, 0.645), False),
    ],
)
def test_balls_lie_on_the_table(place, right):
    data = {**Scene.load('pool').to_dict(), 'table': {}, 'balls': {'8': list(place)}}
    if right:
        assert Scene.from_dict(data).balls['8'] == place
    else:
        with pytest.raises(ValueError, match=r'^scene: balls\.8 must be .*, got \[.*\] \(m\)'):
            Scene.from_dict(data)


def test_a_ball_can_lie_where_it_came_to_rest():
    """One that had stopped at the round end of a nose was refused, which ended a rack."""
    place = 0.04939784602495539, 0.4747806187735074
    scene = dataclasses.replace(Scene.load('seven_foot'), balls={'8': place})
    assert scene.balls['8'] == place


def test_a_carom_table_has_no_mouths():
    data = {**Scene.load('pool').to_dict(), 'balls': {'8': [0, 0.638]}}
    with pytest.raises(
        ValueError, match=r'between the cushions, .* y from -0\.6075 to 0\.6075, got .* \(m\)'
    ):
        Scene.from_dict({**data, 'table': {'pockets': False}})


PAGE = Path(__file__).parents[2] / 'docs' / 'scenes.md'


@pytest.mark.parametrize('block', re.findall(r'```yaml\n(.*?)```', PAGE.read_text(), re.DOTALL))
def test_scenes_in_the_documentation(block, tmp_path):
    path = tmp_path / 'scene.yaml'
    path.write_text(block)
    assert Scene.load(path).ball.mass > 0


def test_bundled_scenes_are_documented():
    named = re.findall(r'`(\w+)`', PAGE.read_text().split('## Bundled scenes')[1])
    assert sorted(named) == scene_names()


def test_numbers_and_names_are_those_of_yaml_1_2(tmp_path):
    """YAML 1.1 reads 010 as 8, 1:30 as 90, and 2024-13-45 as a date that does not exist."""
    path = tmp_path / 'scene.yaml'
    path.write_text(
        'like: pool\nballs: {010: [0.5, 0.1], 1:30: [0.5, 0.3], 2024-13-45: [1, 1e-1]}'
    )
    assert list(Scene.load(path).balls) == ['10', '1:30', '2024-13-45']
    path.write_text('like: pool\nballs: {no: [0.5, 0.1]}')
    with pytest.raises(ValueError, match=r'line 2: balls\.False must be a name.*, got False'):
        Scene.load(path)
    path.write_text('like: pool\nball: {mass: !!float abc}')
    with pytest.raises(ValueError, match=r'scene\.yaml: .*abc'):
        Scene.load(path)


@pytest.mark.parametrize(
    ('text', 'where'), [('', r'empty\.yaml'), ('like: pool\ncue:\n', r'line 2: cue')]
)
def test_what_is_empty_is_called_empty(tmp_path, text, where):
    path = tmp_path / 'empty.yaml'
    path.write_text(text)
    with pytest.raises(ValueError, match=rf'{where} must be a mapping, got None; it is empty$'):
        Scene.load(path)
