"""The atlas: the same whatever computes it, and it goes on where it was interrupted."""
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
import multiprocessing

from layouts import table_with
import numpy as np
import pytest

from billiard_shot.cli import main
from billiard_shot.planning.atlas import chance_at, Chart, compute_atlas, InPlace
from billiard_shot.planning.plan import NOISES


def chart_of(**changes):
    numbers = {'columns': 2, 'rows': 2, 'noise': NOISES['tournament'], 'budget': 150, 'seed': 3}
    scene = table_with(cue=(-.6, 0), b8=(.5, .2), b1=(.635, -.3175))
    return Chart(scene, {'pot': '8'}, '8', **{**numbers, **changes})


@pytest.fixture(scope='module')
def alone(tmp_path_factory):
    return compute_atlas(chart_of(), InPlace(), tmp_path_factory.mktemp('atlas') / 'a.jsonl')


def test_chances_are_those_of_single_places(alone):
    chart = chart_of()
    places = chart.places
    assert alone.shape == (4, 4)
    assert np.isnan(np.diag(alone)).all()  # two balls in one place
    assert np.isnan(alone[places.index((.635, -.3175))]).all()  # where ball 1 lies
    known = alone[np.isfinite(alone)]
    assert ((known >= 0.0) & (known <= 1.0)).all()
    assert known.max() > 0.3
    assert alone[0, 1] == chance_at(chart, places[1], places[0])


def test_processes_give_the_same(alone, tmp_path):
    with ProcessPoolExecutor(2, multiprocessing.get_context('spawn')) as workers:
        assert np.array_equal(
            compute_atlas(chart_of(), workers, tmp_path / 'a.jsonl'), alone, equal_nan=True)


def test_a_dask_cluster_gives_the_same(alone, tmp_path):
    distributed = pytest.importorskip('distributed')
    options = {'threads_per_worker': 1, 'dashboard_address': None, 'processes': True}
    with (distributed.LocalCluster(n_workers=2, **options) as cluster,
          distributed.Client(cluster) as client):
        found = compute_atlas(chart_of(), client, tmp_path / 'a.jsonl')
    assert np.array_equal(found, alone, equal_nan=True)


def test_it_goes_on_where_it_was_interrupted(alone, tmp_path):
    file = tmp_path / 'a.jsonl'
    done = []

    class EnoughError(Exception):
        pass

    def report(count):
        done.append(count)
        if count == 5:
            raise EnoughError

    with pytest.raises(EnoughError):
        compute_atlas(chart_of(), InPlace(), file, report)
    with file.open('a') as out:
        out.write('[3, 1, 0.')  # it was killed as it wrote
    computed = []

    class Counting(InPlace):
        def submit(self, work, /, *arguments):
            computed.append(arguments)
            return super().submit(work, *arguments)

    again = compute_atlas(chart_of(), Counting(), file)
    assert np.array_equal(again, alone, equal_nan=True)
    assert len(computed) == 16 - 5
    before = file.read_text()
    with ThreadPoolExecutor(1) as nobody:
        compute_atlas(chart_of(), nobody, file)
    assert file.read_text() == before


def test_another_atlas_is_not_mixed_in(tmp_path):
    file = tmp_path / 'a.jsonl'
    compute_atlas(chart_of(columns=1, rows=1), InPlace(), file)
    with pytest.raises(ValueError, match='of another atlas'):
        compute_atlas(chart_of(columns=1, rows=1, seed=4), InPlace(), file)
    file.write_text('{"scene\n')
    with pytest.raises(ValueError, match='line 1'):
        compute_atlas(chart_of(columns=1, rows=1), InPlace(), file)


@pytest.mark.parametrize(('changes', 'named'), [
    ({'columns': 0}, 'columns: 0'), ({'budget': 0}, 'budget: 0')])
def test_bad_charts(changes, named):
    with pytest.raises(ValueError, match=named):
        chart_of(**changes)


def test_command(tmp_path, capsys):
    file, picture = tmp_path / 'a.jsonl', tmp_path / 'a.png'
    arguments = ['atlas', 'pool_table', '--grid', '2', '1', '--budget', '150', '--workers', '2',
                 '--file', str(file), '--picture', str(picture)]
    assert main(arguments) == 0
    shown = capsys.readouterr().out
    assert '2 pairs of places' in shown
    assert picture.stat().st_size > 5000
    assert main(arguments) == 0
    assert capsys.readouterr().out == shown
    assert main(['atlas', 'pool_table', '--pocket', 'nowhere']) == 2
