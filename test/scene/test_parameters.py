"""The numbers of scenes by name: read, changed, and refused."""

import numpy as np
import pytest

from billiard_shot import Scene
from billiard_shot.scene.scene import PUBLISHED

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
