"""Former names of keys and attributes: still read, with a warning that names the new one."""

import warnings

import numpy as np
import pytest

from billiard_shot import plan, predict_batch, Scene, simulate
from billiard_shot.planning import atlas
from billiard_shot.planning.targets import read_target
from billiard_shot.table.trajectory import BallState

OLD = {'like': 'pool', 'cue': {'tip_radius': 0.004, 'dome': 0.01}}


def test_former_keys_of_a_scene_are_read_with_a_warning():
    with pytest.warns(FutureWarning) as caught:
        scene = Scene.from_dict(OLD)
    assert [str(warning.message) for warning in caught] == [
        'Cue: the key tip_radius is now called ferrule_radius',
        'Cue: the key dome is now called tip_curvature_radius',
    ]
    assert (scene.cue.ferrule_radius, scene.cue.tip_curvature_radius) == (0.004, 0.01)
    assert scene.cue.mass == Scene.load('pool').cue.mass
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        assert Scene.from_dict(scene.to_dict()) == scene


def test_former_keys_are_inherited(tmp_path):
    (tmp_path / 'old.yaml').write_text('like: pool\ncue: {tip_radius: 0.004}\n')
    (tmp_path / 'new.yaml').write_text('like: old.yaml\ncue: {ferrule_radius: 0.005}\n')
    with pytest.warns(FutureWarning, match='ferrule_radius'):
        assert Scene.load(tmp_path / 'new.yaml').cue.ferrule_radius == 0.005


def test_both_names_of_a_key_are_a_mistake():
    both = {'like': 'pool', 'cue': {'tip_radius': 0.004, 'ferrule_radius': 0.004}}
    with pytest.raises(ValueError, match=r'cue\.tip_radius: unknown key'):
        Scene.from_dict(both)


def test_values_of_former_keys_are_checked():
    with (
        pytest.warns(FutureWarning),
        pytest.raises(ValueError, match=r'cue\.ferrule_radius: -1 is not allowed'),
    ):
        Scene.from_dict({'like': 'pool', 'cue': {'tip_radius': -1}})


def test_former_names_of_limits_and_targets():
    with (
        pytest.warns(FutureWarning, match='azimuth_half_range_deg'),
        pytest.raises(ValueError, match=r'^constraints: azimuth_half_range_deg: -1'),
    ):
        plan(
            Scene.load('pool_table'),
            {'rest': (0.0, 0.0)},
            budget=50,
            constraints={'azimuth_range_deg': -1},
        )
    with pytest.warns(FutureWarning, match='direction_tolerance_deg'):
        assert read_target({'hit': '8', 'within_deg': 3}).direction_tolerance_deg == 3.0


def test_former_attributes():
    scene = Scene.load('pool')
    run = simulate(scene, {'cue': BallState((0, 0, 0.028575), (1, 0, 0))})
    ball = run.balls['cue']
    batch = predict_batch(scene, [(-1, 0, 0)], [(1, 0, 0)])
    for each in (ball, run, batch):
        with pytest.warns(DeprecationWarning, match='now final_position') as caught:
            former = each.rest
        np.testing.assert_equal(former, each.final_position)
        assert [warning.filename for warning in caught] == [__file__]
    with pytest.warns(DeprecationWarning, match='now comes_to_rest'):
        assert ball.rests
    with pytest.warns(DeprecationWarning, match='now azimuth_half_range_deg'):
        assert scene.robot.azimuth_range_deg == 180.0
    with pytest.warns(DeprecationWarning, match='now ferrule_radius'):
        assert scene.cue.tip_radius == 0.0065


def test_former_names_of_atlases(tmp_path):
    with pytest.warns(DeprecationWarning, match='now LayoutResult'):
        assert atlas.PlaceChance is atlas.LayoutResult
    with pytest.raises(AttributeError, match='no attribute'):
        atlas.Places  # noqa: B018
    empty = atlas.Map('8', (0.0, 0.0), (), np.empty((0, 0)))
    with pytest.warns(DeprecationWarning, match='now results'):
        assert empty.chances == ()


def test_files_of_atlases_with_former_keys_go_on(tmp_path):
    scene = Scene.from_dict({'like': 'pool_table', 'cue': {'ferrule_radius': 0.006}})
    request = atlas.AtlasRequest(ball='8', ball_at=[(0.5, 0.2)], cue_grid=(1, 1))
    file = tmp_path / 'a.jsonl'
    atlas.begin(file, scene, request)
    file.write_text(file.read_text().replace('ferrule_radius', 'tip_radius'))
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        assert atlas.begin(file, scene, request) == []
        assert atlas.load_atlas(file).scene == scene
