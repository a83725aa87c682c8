"""success_map(): one plan a place, the same on any executor; and the command that draws it."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
import csv
import io
from itertools import product
import math

import numpy as np
import pytest

from billiard_shot import plan, Scene
from billiard_shot.cli import main
from billiard_shot.planning.success_map import success_map
from billiard_shot.scene.placement import no_place

TABLE = Scene.from_dict({'like': 'pool_table', 'balls': {'8': [0.5, 0.2]}})
SMALL = {'grid': (3, 2), 'budget': 300}


@pytest.fixture(scope='module')
def alone():
    return success_map(TABLE, '8', **SMALL)


def same(one, other):
    return all(
        np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)
        for name in ('x', 'y', 'success', 'low', 'high')
    )


def test_a_place_is_a_plan(alone):
    number, place = 4, (float(alone.x[1]), float(alone.y[1]))
    scene = Scene.from_dict({**TABLE.to_dict(), 'balls': {'8': [0.5, 0.2], 'cue': place}})
    best = plan(scene, {'pot': '8'}, budget=300, seed=1 + number).best
    assert alone.success[1, 1] == best.success
    assert (alone.low[1, 1], alone.high[1, 1]) == best.interval


def test_near_and_straight_is_surer_than_far_and_thin(alone):
    assert alone.success.shape == (2, 3)
    assert np.nanmax(alone.success) > np.nanmin(alone.success) + 0.2
    assert ((alone.low <= alone.success) & (alone.success <= alone.high)).all()


def test_cells_fill_the_room_for_balls_and_are_empty_where_another_lies():
    scene = Scene.load('nine_ball')
    made = success_map(scene, '1', (7, 5), budget=1)
    assert made.x[-1] - made.x[0] == pytest.approx(
        6 / 7 * (scene.table.length - 2 * scene.ball.radius)
    )
    assert np.ptp(made.y) == pytest.approx(4 / 5 * (scene.table.width - 2 * scene.ball.radius))
    for (i, y), (j, x) in product(enumerate(made.y), enumerate(made.x)):
        taken = no_place(scene.table, x, y, scene.ball.radius, scene.object_balls)
        assert math.isnan(made.success[i, j]) == bool(taken)
    assert np.isnan(made.success).any()


def test_threads_and_processes_make_the_same(alone):
    done = []
    for kind in (ThreadPoolExecutor, ProcessPoolExecutor):
        with kind(2) as executor:
            made = success_map(TABLE, '8', **SMALL, executor=executor, report=done.append)
        assert same(made, alone)
    assert done == [1, 2, 3, 4, 5, 6] * 2


@pytest.mark.slow
@pytest.mark.filterwarnings('ignore::DeprecationWarning')
def test_a_dask_cluster_makes_the_same(alone):
    distributed = pytest.importorskip('distributed', reason='needs Dask, an extra')
    options = {'n_workers': 2, 'threads_per_worker': 1, 'dashboard_address': None}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        assert same(success_map(TABLE, '8', **SMALL, executor=client.get_executor()), alone)


@pytest.mark.parametrize(
    ('scene', 'changes', 'text'),
    [
        ('pool_table', {}, "ball must be in the scene, which has only the cue ball, got '8'"),
        ('blocked', {'ball': '9'}, "ball must be one of 1, 8, got '9'"),
        ('blocked', {'pocket': 'foot'}, 'pocket'),
        ('carom', {'ball': 'red'}, 'pocket'),
        ('blocked', {'grid': (0, 2)}, r'grid\[0\] must be a whole number, at least 1, got 0'),
    ],
)
def test_wrong_requests(scene, changes, text):
    with pytest.raises(ValueError, match=text):
        success_map(scene, **{'ball': '8', **changes})


def test_the_command_prints_and_draws(alone, tmp_path, capsys):
    picture = tmp_path / 'map.png'
    words = ['map', 'pool_table', '--ball', '8', '--ball-at', '0.5', '0.2', '--grid', '3x2']
    words += ['--budget', '300', '--workers', '1']
    assert main([*words, '--picture', str(picture)]) == 0
    out, err = capsys.readouterr()
    mean = 100 * np.nanmean(alone.success)
    assert out.startswith(f'ball 8 at (0.5, 0.2) m: {mean:.0f} % on average of 6 places, each ± ')
    assert err == ''
    assert picture.read_bytes().startswith(b'\x89PNG')
    assert main([*words, '--csv']) == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert [float(row['success']) for row in rows] == alone.success.ravel().tolist()
    with pytest.raises(SystemExit):
        main(['map', 'blocked', '--ball', '8', '--grid', '3'])
    assert "must be two whole numbers, such as 24x12, got '3'" in capsys.readouterr().err
