import pickle

import pytest

from billiard_shot.scene import CornerPocket, Cushion, Scene, Table


@pytest.fixture
def data():
    return Scene.load('pool').to_dict()


def test_a_scene_without_table_has_an_endless_cloth(data):
    assert 'table' not in data
    assert Scene.from_dict(data).table is None


def test_default_table_is_nine_feet_of_the_wpa(data):
    scene = Scene.from_dict(data | {'table': {}})
    assert scene.table == Table()
    assert (scene.table.length, scene.table.width) == (2.54, 1.27)
    assert Scene.from_dict(scene.to_dict()) == scene
    assert pickle.loads(pickle.dumps(scene)) == scene


def test_a_cushion_model_brings_its_numbers():
    assert (Cushion().restitution, Cushion().friction) == (0.98, 0.14)
    assert (Cushion('han').restitution, Cushion('han').friction) == (0.85, 0.2)
    assert Cushion('han', 0.7).restitution == 0.7


def test_cushions_are_slower_than_balls(data):
    """So the one contact acts at once within the other."""
    data['contacts']['ball_ball']['duration'] = 3e-4
    assert Scene.from_dict(data | {'table': {'cushion': {'duration': 3e-3}}})
    assert Scene.from_dict(data | {'table': {'cushion': {'duration': 0}}})
    with pytest.raises(
        ValueError, match=r'cushion\.duration must .*ten times .* 0\.003.*, got 0\.002'
    ):
        Scene.from_dict(data | {'table': {'cushion': {'duration': 0.002}}})


def test_carom_table(data):
    scene = Scene.from_dict(data | {'table': {'length': 2.84, 'width': 1.42, 'pockets': False}})
    assert not scene.table.pockets


@pytest.mark.parametrize(
    ('table', 'mistake'),
    [
        ({'length': 0}, r'table\.length must .* above 0 and at most 20, got 0 \(m\)'),
        ({'lenght': 2}, r'table\.lenght is unknown; the nearest key is length'),
        ({'corner': {'cut_deg': 90}}, r'table\.corner\.cut_deg must .*above 90.*, got 90'),
        (
            {'cushion': {'model': 'rubber'}},
            r"table\.cushion\.model must .* mathavan, han, stronge, got 'rubber'",
        ),
        ({'width': 0.17}, r'table\.width must be above 0\.1785 with these pockets, got 0\.17'),
    ],
)
def test_mistakes_are_named(data, table, mistake):
    with pytest.raises(ValueError, match=mistake):
        Scene.from_dict(data | {'table': table})


def test_pockets_need_room_only_where_there_are_any():
    assert Table(width=0.17, pockets=False).width == 0.17
    with pytest.raises(ValueError, match='width must be above'):
        Table(corner=CornerPocket(mouth=1.0))
