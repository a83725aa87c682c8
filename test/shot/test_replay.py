"""Shots written as JSON come back bit for bit."""

import dataclasses
import json

from hypothesis import given, HealthCheck, settings
from hypothesis import strategies as st
import numpy as np
import pytest

from billiard_shot import effects_of, load_shot, predict, save_shot, Scene, Stroke
from billiard_shot.shot.replay import from_json, to_json
from billiard_shot.table.run.results import TableRun

FROZEN = Scene.from_dict({'like': 'pool_table', 'balls': {'cue': [0, 0], '1': [0.05715, 0]}})
SHOTS = {
    'masse': predict(Scene.load('paper'), Stroke((-2, -1, 12), (4, 0, -16))),
    'horizontal': predict(Scene.load('paper'), Stroke((-1, -1, 0), (0.8, 0, 0)), 1e-6),
    'combination': predict(
        Scene.load('frozen_combination'), Stroke.from_offsets(0.2, 0.3, 0.1, 0.55, 3)
    ),
    'break': predict(Scene.load('nine_ball'), Stroke.from_offsets(0, 0.1, 0.1, -0.1, 6)),
    'elsewhere': predict(
        Scene.load('pool'), Stroke.from_offsets(0.1, 0, 0.1, 2, 1), position=(0.3, -0.1)
    ),
    'miscue': predict(Scene.load('pool'), Stroke.from_offsets(0.8, 0, 0, 0, 2)),
    'refused': predict(Scene.load('eight_ball'), Stroke.from_offsets(0.9, 0.9, 0, 0, 1)),
    'frozen': predict(FROZEN, Stroke.from_offsets(0.1, 0.1, 0.2, 0.3, 2)),
    'endless': predict(
        Scene.from_dict({'like': 'pool', 'cloth': {'rolling_resistance': 0}}),
        Stroke.from_offsets(0, 0, 0.1, 0, 1),
    ),
    'rounded tip': predict(
        Scene.from_dict({'like': 'pool', 'cue': {'mass': 0.5, 'tip_curvature_radius': 0.01}}),
        Stroke.from_pose((-0.5, 0.01, 0.0285), (0, 0, 0, 1), 1.5, (0, 0, 0.028575)),
    ),
    'chaos of an energetic law': predict(
        Scene.from_dict({'like': 'paper', 'contacts': {'cue_ball': {'stiffness': 1.1}}}),
        Stroke.from_offsets(0.1, 0.3, 1.0, 0.2, 3),
    ),
}


def bits(value):
    """All numbers in a value, as bytes."""
    if isinstance(value, np.ndarray | np.void):
        if value.dtype.names:  # without the bytes between the fields
            return [(name, bits(value[name])) for name in value.dtype.names]
        return value.dtype, value.shape, value.tobytes()
    if isinstance(value, np.generic):
        return value.tobytes()
    if isinstance(value, TableRun):
        return [bits(getattr(value, field.name)) for field in dataclasses.fields(value)]
    if dataclasses.is_dataclass(value):
        return [
            (field.name, bits(getattr(value, field.name))) for field in dataclasses.fields(value)
        ]
    if isinstance(value, tuple | list):
        return [bits(item) for item in value]
    return value


@pytest.mark.parametrize('name', SHOTS)
def test_everything_comes_back_bit_for_bit(name):
    shot = SHOTS[name]
    back = from_json(to_json(shot))
    assert back.scene == shot.scene
    assert bits(back.stroke) == bits(shot.stroke)
    for field in dataclasses.fields(shot):
        if field.name not in ('scene', 'stroke'):
            assert bits(getattr(back, field.name)) == bits(getattr(shot, field.name)), field.name
    for derived in ('status', 'miscue', 'message', 'double_hit', 'error_estimate', 'evaluations'):
        assert getattr(back, derived) == getattr(shot, derived)
    assert bits(back.impact) == bits(shot.impact)
    assert [e.simulated for e in effects_of(back)] == [e.simulated for e in effects_of(shot)]
    times = np.linspace(0, shot.trajectory.duration, 50)
    assert bits(back.trajectory.at(times)) == bits(shot.trajectory.at(times))
    assert bits(back.run.events) == bits(shot.run.events)
    assert back.run.pocketed == shot.run.pocketed
    assert to_json(back) == to_json(shot)


@pytest.mark.parametrize('name', SHOTS)
def test_what_is_recorded_is_enough_to_play_it_again(name):
    back = from_json(to_json(SHOTS[name]))
    position = json.loads(to_json(SHOTS[name]))['position']
    again = predict(back.scene, back.stroke, back.tolerance, position[:2])
    assert again.status == back.status
    assert bits(again.trajectory.rows) == bits(back.trajectory.rows)
    assert bits(again.velocity) == bits(back.velocity)


@settings(max_examples=40, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    normal=st.tuples(*[st.floats(-1, 1)] * 3),
    speed=st.floats(0.05, 10),
    elevation=st.floats(0, 1.5),
    azimuth=st.floats(-3, 3),
)
def test_any_stroke(normal, speed, elevation, azimuth):
    if not any(normal):
        return
    along = Stroke.from_offsets(0, 0, elevation, azimuth, speed).velocity
    shot = predict(Scene.load('pool'), Stroke(normal, along))
    back = from_json(to_json(shot))
    assert bits(back.stroke) == bits(shot.stroke)
    assert bits(back.trajectory.rows) == bits(shot.trajectory.rows)
    assert back.message == shot.message


def test_it_is_json_that_others_can_read():
    def refuse(name):
        raise AssertionError(f'{name} is not JSON')

    data = json.loads(to_json(SHOTS['masse']), parse_constant=refuse)
    assert data['strike']['velocity'] == SHOTS['masse'].velocity.tolist()
    assert data['status'] == 'OK'
    assert data['scene']['cue']['mass'] == 0.5018


def test_numbers_that_json_does_not_know():
    strike = SHOTS['masse']._cue.copy()
    strike['drift'] = -np.inf
    shot = dataclasses.replace(SHOTS['masse'], _cue=strike, error_estimate=np.inf)
    back = from_json(to_json(shot))
    assert back.error_estimate == np.inf
    assert back._cue['drift'] == -np.inf


def test_an_impact_of_more_balls_than_a_double_has_bits():
    row = {str(i): (0.3 + 0.05715 * i, 0.0) for i in range(60)}
    scene = Scene.from_dict({'like': 'pool', 'balls': {'cue': [0, 0], **row}})
    shot = predict(scene, Stroke.from_offsets(0, 0, 0, 0, 1))
    back = from_json(to_json(shot))
    assert max(len(event.balls) for event in shot.run.events) == 61
    assert [event.balls for event in back.run.events] == [event.balls for event in shot.run.events]


def test_files(tmp_path):
    save_shot(SHOTS['break'], tmp_path / 'shot.json')
    assert load_shot(tmp_path / 'shot.json').velocity.tolist() == SHOTS['break'].velocity.tolist()
    for path, text in ((tmp_path / 'no' / 'shot.json', 'No such file'),):
        with pytest.raises(ValueError, match=text):
            load_shot(path)
        with pytest.raises(ValueError, match=text):
            save_shot(SHOTS['break'], path)


@pytest.mark.parametrize(
    ('change', 'text'),
    [
        (lambda data: data.update(format='x'), "format must be 'billiard_shot shot'"),
        (lambda data: data.update(version=99), 'version must be 2, got 99'),
        (lambda data: data.pop('strike'), 'incomplete or damaged'),
        (lambda data: data['strike'].pop('spin'), "incomplete or damaged: KeyError 'spin'"),
        (
            lambda data: data['run']['segments'].update(spin=[[1, 2]]),
            r'run: segments: spin must have shape \(11, 3\), got \(1, 2\)',
        ),
        (lambda data: data['scene']['ball'].update(mass=-1), 'mass'),
        (lambda data: data['stroke'].update(velocity=[0, 0, 0]), r'velocity '),
        (lambda data: data.update(run=7), 'incomplete or damaged'),
        (lambda data: data['strike'].update(hits=10**30), 'incomplete or damaged'),
        (lambda data: data['strike'].update(spin={'float': None}), 'incomplete or damaged'),
    ],
)
def test_damaged_records(change, text):
    data = json.loads(to_json(SHOTS['masse']))
    change(data)
    with pytest.raises(ValueError, match=text):
        from_json(json.dumps(data))


def test_what_is_no_shot_and_no_path():
    with pytest.raises(ValueError, match='shot must be a Shot, got None'):
        save_shot(None, 'shot.json')
    for refused in (lambda: save_shot(SHOTS['break'], None), lambda: load_shot(None)):
        with pytest.raises(ValueError, match=r'None: .*str'):
            refused()


def test_a_ball_may_have_the_name_of_a_type():
    scene = Scene.from_dict({'like': 'pool_table', 'balls': {'float': (0.5, 0.1)}})
    shot = predict(scene, Stroke.from_offsets(0, 0, 0.1, 0, 1))
    assert from_json(to_json(shot)).scene == scene


@pytest.mark.parametrize('text', ['[' * 100_000, '', '{', '[]', '7', '"shot"', 'null'])
def test_what_is_no_record(text):
    with pytest.raises(ValueError, match=r'must be JSON|not a shot'):
        from_json(text)
