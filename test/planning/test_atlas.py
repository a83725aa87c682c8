"""An atlas: the same whoever makes it, and never the same work twice."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
import json
import math
import os
import signal
import subprocess
import sys
import time

from hypothesis import given, settings
from hypothesis import strategies as st
from layouts import cloth_with, table_with
import numpy as np
import pytest
from setups import SLOW_CLOTH

from billiard_shot import plan, Scene, Status
from billiard_shot.cli import main
from billiard_shot.cli.workers import working
from billiard_shot.planning.atlas import (
    append,
    Atlas,
    atlas,
    AtlasRequest,
    build,
    Layout,
    layouts_of,
    load_atlas,
    start_file,
)
from billiard_shot.planning.atlas.layouts import borders, grid, scene_at
from billiard_shot.scene import Noise

SCENE = table_with(cue=(-0.4, 0), b8=(0.5, 0.2), b1=(0.2, -0.3))
# As scenes were before contacts had durations.
RATIO = Scene.from_dict({'like': 'pool', 'contacts': SLOW_CLOTH}).contacts
SLOW = replace(SCENE, contacts=RATIO)
SMALL = AtlasRequest(ball='8', cue_grid=(3, 2), budget=120)


@pytest.fixture(scope='module')
def alone():
    """What one thread makes of the small request."""
    return {result.layout: result for result in atlas(SCENE, SMALL)}


def as_set(results):
    found = {result.layout: result for result in results}
    assert len(found) > 0
    return found


@given(st.integers(1, 40), st.integers(1, 25))
@settings(max_examples=30)
def test_a_grid_fills_the_room_for_balls(columns, rows):
    table, radius = SCENE.table, SCENE.ball.radius
    layouts = np.array(grid(table, radius, (columns, rows)))
    x, y = borders(table, radius, (columns, rows))
    assert (x[-1], y[-1]) == (table.length / 2 - radius, table.width / 2 - radius)
    assert np.ptp(np.diff(x)) < 1e-12
    assert len(set(map(tuple, layouts))) == columns * rows
    assert np.allclose(layouts[:columns, 0], (x[1:] + x[:-1]) / 2, atol=1e-6)
    assert np.allclose(layouts[::columns, 1], (y[1:] + y[:-1]) / 2, atol=1e-6)


def test_places_are_all_those_where_the_balls_have_room():
    request = AtlasRequest(ball='8', cue_grid=(31, 17), ball_grid=(3, 3))
    layouts = set(layouts_of(SCENE, request))
    own = grid(SCENE.table, SCENE.ball.radius, (3, 3))
    every = {
        Layout('8', there, here)
        for there in own
        for here in grid(SCENE.table, SCENE.ball.radius, (31, 17))
    }
    assert 0 < len(every - layouts) < 0.05 * len(every)
    for layout in list(layouts)[::40]:
        assert scene_at(SCENE, layout).balls == {
            'cue': layout.cue_place,
            '8': layout.ball_place,
            '1': (0.2, -0.3),
        }
    for layout in every - layouts:
        with pytest.raises(ValueError, match="mm from ball 'cue', which it overlaps by"):
            scene_at(SCENE, layout)


def test_racked_balls_stay_where_they_are():
    scene = Scene.load('nine_ball')
    request = AtlasRequest(ball='1', ball_at=[(-0.5, 0.3)], cue_grid=(2, 2))
    moved = scene_at(scene, layouts_of(scene, request)[0])
    assert moved.balls['1'] == (-0.5, 0.3)
    assert moved.balls['9'] == scene.balls['9']


def test_a_place_is_a_plan(alone):
    layout = next(layout for layout, result in alone.items() if result.stroke)
    planned = plan(
        scene_at(SCENE, layout),
        {'pot': '8'},
        budget=SMALL.budget,
        seed=build._seed(SMALL.seed, layout),
    )
    result = alone[layout]
    assert result.stroke == planned.best.stroke.offsets
    assert (result.success, result.interval) == (planned.best.success, planned.best.interval)
    assert (result.kind, result.message) == (planned.best.kind, planned.message)
    assert result.simulations == planned.simulations <= SMALL.budget


def test_a_part_of_it_is_the_same_as_in_the_whole(alone):
    some = list(alone)[::-2]
    assert list(atlas(SCENE, SMALL, some)) == [alone[layout] for layout in some]
    # A finer grid has the layouts of a coarser one in it.
    finer = AtlasRequest(ball='8', cue_grid=(9, 6), budget=SMALL.budget)
    common = set(layouts_of(SCENE, finer)) & set(alone)
    assert len(common) >= 3
    assert as_set(atlas(SCENE, finer, common)) == {layout: alone[layout] for layout in common}


def test_seeds_and_places_draw_different_numbers(alone):
    seeds = {build._seed(seed, layout) for seed in (1, 2) for layout in alone}
    assert len(seeds) == 2 * len(alone)
    other = as_set(atlas(SCENE, AtlasRequest(ball='8', cue_grid=(3, 2), budget=120, seed=2)))
    assert set(other) == set(alone)
    assert other != alone


def test_who_plays_counts():
    layout = Layout('8', (0.5, 0.2), (-0.9, -0.3))

    def success(**changes):
        results = atlas(SCENE, AtlasRequest(ball='8', budget=600, **changes), [layout])
        return next(results).success

    assert success(noise=Noise().times(0.0)) == 1.0
    assert success(noise=Noise().times(0.5)) > success() > success(noise=Noise().times(3.0))


def test_near_and_straight_is_surer_than_far_and_thin():
    request = AtlasRequest(ball='8', ball_at=[(1.0, 0.4)], budget=600, pocket='foot_left')
    scene = table_with(cue=(0, 0))
    near, far = (Layout('8', (1.0, 0.4), here) for here in ((0.75, 0.21), (1.1, -0.5)))
    best, worst = atlas(scene, request, [near, far])
    assert best.interval[0] > worst.interval[1]


def test_where_the_cue_has_no_room():
    data = SCENE.to_dict()
    data['robot'] = {'elevation_max_deg': 3, 'azimuth_deg': 0, 'azimuth_half_range_deg': 20}
    low = Scene.from_dict(data)
    near, free = (Layout('8', (0.5, 0.2), (x, 0.0)) for x in (-1.2, 0.0))
    results = as_set(atlas(low, SMALL, [near, free]))
    assert results[near].status == Status.INVALID_REQUEST
    assert 'elevation_max_deg' in results[near].message
    assert (results[near].success, results[near].interval) == (0.0, (0.0, 1.0))
    assert results[free].status == Status.OK


def test_threads_and_processes_make_the_same(alone):
    with ThreadPoolExecutor(3) as threads:
        assert as_set(atlas(SCENE, SMALL, executor=threads)) == alone
    with working(2, None) as processes:
        assert as_set(atlas(SCENE, SMALL, executor=processes)) == alone


@pytest.mark.slow
@pytest.mark.filterwarnings('ignore::DeprecationWarning')
def test_a_dask_cluster_makes_the_same(alone):
    distributed = pytest.importorskip('distributed', reason='needs Dask, an extra')
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        dashboard_address=None,
    ) as cluster:
        with working(1, cluster.scheduler_address) as executor:
            assert as_set(atlas(SCENE, SMALL, executor=executor)) == alone
        with distributed.Client(cluster) as client:
            done = client.run(lambda dask_worker: dask_worker.state.executed_count)
    assert len(done) == 2
    assert min(done.values()) > 0  # both had a part in it


def test_without_dask_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, 'distributed', None)
    with (
        pytest.raises(ValueError, match=r"pip install 'billiard_shot\[dask\]'"),
        working(1, 'local'),
    ):
        pass


class Threads(ThreadPoolExecutor):
    """Counts what is under way."""

    def __init__(self):
        super().__init__(2)
        self.futures = []

    def submit(self, work, /, *arguments):
        self.futures.append(super().submit(work, *arguments))
        return self.futures[-1]


def test_what_is_handed_out_ahead_is_bounded_and_given_back(alone, monkeypatch):
    monkeypatch.setattr(build, 'AHEAD', 3)
    monkeypatch.setattr(build, 'plan_layout', lambda scene, request, layout: layout)
    layouts = [Layout('8', (0.5, 0.2), (0.0, 0.01 * i)) for i in range(20)]
    with Threads() as threads:
        results = atlas(SCENE, SMALL, layouts, threads)
        first = [next(results) for _ in range(5)]
        assert len(threads.futures) <= 5 + 3
        assert len(set(first)) == 5
        results.close()
    assert len(threads.futures) <= 5 + 3
    with Threads() as threads:
        assert set(atlas(SCENE, SMALL, layouts, threads)) == set(layouts)


def test_what_goes_wrong_in_a_worker_is_said(monkeypatch):
    monkeypatch.setattr(build, 'plan_layout', lambda *_: 1 / 0)
    with ThreadPoolExecutor(1) as threads, pytest.raises(ZeroDivisionError):
        list(atlas(SCENE, SMALL, executor=threads))


@pytest.mark.parametrize(
    ('changes', 'named'),
    [
        ({'ball': 'cue'}, r"ball must be .*, got 'cue'"),
        ({'ball': ['8', '8']}, r'ball .*different'),
        ({'ball': 8}, r'ball must .*, got 8'),
        ({'pocket': 'middle'}, r'pocket .*foot_left'),
        ({'cue_grid': (0, 3)}, r'cue_grid .*at least 1'),
        ({'cue_grid': None}, r'cue_grid must .*, got None'),
        ({'cue_grid': (2.5, 3)}, 'cue_grid'),
        ({'ball_grid': 3}, r'ball_grid must .*, got 3'),
        ({'ball_at': [(0, math.nan)]}, r'ball_at .*finite'),
        ({'ball_at': 1}, r'ball_at must .*, got 1'),
        (
            {'ball_at': [(0, 0)], 'ball_grid': (2, 2)},
            'ball_grid must not be given together with ball_at',
        ),
        ({'budget': 0}, r'budget must .*, got 0'),
        ({'seed': -1}, r'seed must .*, got -1'),
        ({'noise': 'loud'}, 'noise'),
    ],
)
def test_a_request_that_makes_no_sense(changes, named):
    with pytest.raises(ValueError, match=named):
        AtlasRequest(**changes)


@pytest.mark.parametrize(
    ('scene', 'changes', 'named'),
    [
        (SCENE, {}, 'ball is missing; the scene has 8, 1'),
        (
            SCENE,
            {'ball': '7'},
            "ball must be one of 8, 1, got '7'; ball_at or ball_grid",
        ),
        (Scene.load('pool_table'), {}, 'ball is missing; the scene has only the cue ball'),
        (
            cloth_with(cue=(0, 0), b8=(1, 0)),
            {'ball': '8'},
            'pocket needs a table with pockets; the scene has none',
        ),
        (
            Scene.load('carom'),
            {'ball': 'red'},
            'pocket needs a table with pockets; the scene has none',
        ),
        (
            SCENE,
            {'ball': '8', 'ball_at': [(2, 0)]},
            r'ball_at must be between the cushions, .*, got \(2\.0, 0\.0\)',
        ),
        (
            SCENE,
            {'ball': '8', 'ball_at': [(0.2, -0.29)]},
            r"ball_at must .* ball '1', which it overlaps by 47.1 mm, got \(0.2, -0.29\) \(m\)",
        ),
        (
            table_with(cue=(-0.5, 0), b8=(0, 0.03)),
            {'ball': '8', 'cue_grid': (1, 1)},
            r'cue_grid must have a position .*, got \(1, 1\)',
        ),
    ],
)
def test_a_request_that_does_not_fit_the_scene(scene, changes, named):
    with pytest.raises(ValueError, match=named):
        layouts_of(scene, AtlasRequest(**changes))


def test_the_only_ball_need_not_be_named():
    scene = table_with(cue=(0, 0), b3=(0.5, 0.2))
    assert {layout.ball for layout in layouts_of(scene, AtlasRequest(cue_grid=(2, 2)))} == {'3'}


def test_a_file_gives_back_what_was_put_into_it(alone, tmp_path):
    file = tmp_path / 'atlas.jsonl'
    assert start_file(file, SCENE, SMALL) == []
    for result in alone.values():
        append(file, result)
    assert start_file(file, SCENE, SMALL) == list(alone.values())
    made = load_atlas(file)
    assert made.scene == SCENE
    assert (made.request.ball, made.request.noise) == (('8',), SCENE.noise)
    assert list(made.results) == list(alone.values())
    # Others read it without this library.
    lines = [json.loads(line) for line in file.read_text().splitlines()]
    assert lines[0]['cue_grid'] == [3, 2]
    assert all(
        low <= line['success'] <= high for line in lines[1:] for low, high in [line['interval']]
    )


def test_a_line_that_was_not_finished_is_done_again(alone, tmp_path):
    file = tmp_path / 'atlas.jsonl'
    start_file(file, SCENE, SMALL)
    first, second, *_ = alone.values()
    append(file, first)
    kept = file.read_bytes()
    append(file, second)
    file.write_bytes(file.read_bytes()[:-20])
    assert start_file(file, SCENE, SMALL) == [first]
    assert file.read_bytes() == kept


@pytest.mark.parametrize(
    ('scene', 'request_', 'named'),
    [
        (SCENE, {'budget': 500}, 'budget: 120 in the file, 500 in the request'),
        (SCENE, {'seed': 3}, 'seed: 1 in the file, 3 in the request'),
        (SCENE, {'cue_grid': (4, 4)}, r'cue_grid: \[3, 2\] in the file, \[4, 4\] in the request'),
        (SCENE, {'pocket': 'foot_left'}, 'pocket: .* in the file'),
        (SCENE, {'ball': '1'}, 'ball: '),
        (
            SCENE,
            {'ball_grid': (1, 1)},
            r'ball_grid: not given in the file, \[1, 1\] in the request',
        ),
        (SCENE, {'noise': Noise(a=0.001)}, 'noise.a: 0.0005 in the file, 0.001 in the request'),
        (
            table_with(cue=(-0.4, 0), b8=(0.5, 0.2), b1=(0.2, -0.25)),
            {},
            r'scene.balls.1: \[0.2, -0.3\] in the file, \[0.2, -0.25\] in the request',
        ),
        (
            SLOW,
            {},
            'scene.contacts.ball_table.duration: 0.0007 in the file, not given in the request',
        ),
    ],
)
def test_a_file_of_another_atlas_is_refused(scene, request_, named, tmp_path):
    file = tmp_path / 'atlas.jsonl'
    start_file(file, SCENE, SMALL)
    before = file.read_bytes()
    other = AtlasRequest(**{'ball': '8', 'cue_grid': (3, 2), 'budget': 120, **request_})
    with pytest.raises(ValueError, match=rf'holds another atlas\n  {named}'):
        start_file(file, scene, other)
    assert file.read_bytes() == before


@pytest.mark.parametrize('text', ['my notes', '{}\n', '[1]\n', '{"atlas": 9, "scene": {}}\n'])
def test_a_file_of_something_else_is_left_alone(text, tmp_path):
    file = tmp_path / 'atlas.jsonl'
    file.write_text(text)
    for read in (lambda: start_file(file, SCENE, SMALL), lambda: load_atlas(file)):
        with pytest.raises(ValueError, match=r'atlas\.jsonl.*(must be|is not an atlas file)'):
            read()
    assert file.read_text() == text


def test_a_broken_line_is_named(tmp_path):
    file = tmp_path / 'atlas.jsonl'
    start_file(file, SCENE, SMALL)
    with file.open('a') as open_file:
        open_file.write('{"ball": "8"}\n')
    with pytest.raises(ValueError, match='line 2 is not a result'):
        start_file(file, SCENE, SMALL)


def test_files_that_cannot_be(tmp_path, alone):
    missing = tmp_path / 'nowhere' / 'atlas.jsonl'
    for act in (
        lambda: start_file(missing, SCENE, SMALL),
        lambda: load_atlas(missing),
        lambda: append(missing, next(iter(alone.values()))),
    ):
        with pytest.raises(ValueError, match='nowhere'):
            act()


def test_maps_are_on_the_grid(alone):
    made = Atlas(SCENE, SMALL, list(alone.values())[1:])
    (drawn,) = made.maps
    assert drawn.success.shape == (2, 3)
    first = next(iter(alone))
    assert first.cue_place == min(grid(SCENE.table, SCENE.ball.radius, (3, 2)))
    assert np.isnan(drawn.success[0, 0])
    assert np.isnan(drawn.success).sum() == 1
    assert drawn.success[1, 2] == alone[max(alone)].success
    assert drawn.mean == pytest.approx(np.nanmean(drawn.success))


def test_maps_stand_as_on_the_table():
    request = AtlasRequest(ball='8', cue_grid=(2, 1), ball_grid=(2, 2))
    corners = [each.ball_place for each in Atlas(SCENE, request, []).maps]
    assert [(x > 0, y > 0) for x, y in corners] == [
        (False, True),
        (True, True),
        (False, False),
        (True, False),
    ]


COMMAND = [
    'atlas',
    'pool_table',
    '--ball',
    '8',
    '--ball-at',
    '.6',
    '0',
    '--cue-grid',
    '3x2',
    '--budget',
    '120',
]


def test_the_command_goes_on_where_it_was(tmp_path, capsys):
    file = tmp_path / 'a.jsonl'
    command = [*COMMAND, '--workers', '1', '--output', str(file)]
    assert main(command) == 0
    out, err = capsys.readouterr()
    assert err == ''
    assert out.splitlines()[2].split()[:4] == ['8', '0.600', '0.000', '6']
    whole = file.read_text().splitlines(keepends=True)
    assert len(whole) == 7
    file.write_text(''.join(whole[:4]))
    assert main(command) == 0
    assert '6 layouts, 3 of them from' in capsys.readouterr().out
    assert file.read_text().splitlines(keepends=True) == whole
    pytest.importorskip('matplotlib', reason='needs matplotlib, an extra')
    picture = tmp_path / 'a.png'
    assert main([*command, '--picture', str(picture)]) == 0
    assert '; 0 strokes simulated' in capsys.readouterr().out
    assert picture.stat().st_size > 10_000
    assert main([*command, '--seed', '2']) == 2
    assert 'seed: 1 in the file, 2 in the request' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('arguments', 'text'),
    [
        (['--workers', '0'], '--workers must be at least 1, got 0'),
        (['--noise-scale', '-1'], '--noise-scale must be at least 0, got -1.0'),
        (['--budget', '0'], 'budget must be a whole number, at least 1, got 0'),
        (['--ball', 'cue'], ", got ('8', 'cue')"),
        (['--dask', 'tcp://'], '--dask: '),
        (
            ['--picture', 'nowhere/a.png'],
            '--picture must be in a folder that exists, got nowhere/a.png',
        ),
    ],
)
def test_wrong_input_of_the_command(arguments, text, capsys):
    assert main([*COMMAND, *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ''
    assert err.startswith('billiard-shot: ')
    assert text in err


def test_a_grid_that_is_none(capsys):
    with pytest.raises(SystemExit):
        main([*COMMAND, '--ball-grid', '3'])
    assert "must be two whole numbers, such as 24x12, got '3'" in capsys.readouterr().err


@pytest.fixture
def heeds_interrupts():
    """Start processes that heed SIGINT even where the tests run in the background of a shell."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope='module')
def uninterrupted(tmp_path_factory):
    """Lines of a file that was written in one go."""
    file = tmp_path_factory.mktemp('atlas') / 'a.jsonl'
    assert main([*COMMAND, '--cue-grid', '5x4', '--workers', '1', '--output', str(file)]) == 0
    return sorted(file.read_text().splitlines())


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == 'win32', reason='no process groups there')
@pytest.mark.xdist_group('interrupted')  # one worker computes what both are compared with
@pytest.mark.usefixtures('heeds_interrupts')
@pytest.mark.parametrize('end', [signal.SIGINT, signal.SIGKILL])
def test_whatever_ends_it_leaves_a_file_to_go_on_with(end, tmp_path, uninterrupted):
    """Ctrl-C to a whole process group, as a terminal sends it; or one process killed."""
    file = tmp_path / 'a.jsonl'
    command = [
        sys.executable,
        '-m',
        'billiard_shot.cli',
        *COMMAND,
        '--cue-grid',
        '5x4',
        '--output',
        str(file),
    ]
    first = subprocess.Popen(
        [*command, '--workers', '2'],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    while first.poll() is None and (not file.exists() or file.read_bytes().count(b'\n') < 4):
        time.sleep(0.02)
    if end == signal.SIGINT:
        os.killpg(first.pid, end)
    else:
        first.send_signal(end)
    out, err = first.communicate(timeout=60)  # until all its workers have closed them, too
    assert out == ''
    if end == signal.SIGINT:
        assert first.returncode == 130
        assert err.startswith('interrupted: ')
        assert err.count('\n') == 1
    kept = file.read_bytes()
    assert 4 <= kept.count(b'\n') < 21
    again = subprocess.run(
        [*command, '--workers', '1'], capture_output=True, text=True, check=True
    )
    assert 'of them from' in again.stdout
    assert file.read_bytes().startswith(kept)
    assert sorted(file.read_text().splitlines()) == uninterrupted
