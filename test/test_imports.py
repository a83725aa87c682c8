"""No module imports itself through others, not even when a function runs."""

from graphlib import CycleError, TopologicalSorter

import grimp
import pytest

PACKAGE = 'billiard_shot'
SHOWN = {  # modules whose methods, such as `Shot.view`, load pictures of them
    'shot.shot': ('canvas', 'table', 'view'),
    'calibration.result': ('calibration',),
}


@pytest.fixture(scope='module')
def graph():
    found = grimp.build_graph(PACKAGE, exclude_type_checking_imports=True, cache_dir=None)
    return {module: found.find_modules_directly_imported_by(module) for module in found.modules}


def test_only_what_shows_itself_imports_what_imports_it(graph):
    with pytest.raises(CycleError, match='cycle'):
        TopologicalSorter(graph).prepare()
    graph = dict(graph)
    for name, pictures in SHOWN.items():
        module = f'{PACKAGE}.{name}'
        graph[module] = graph[module] - {f'{PACKAGE}.pictures.{each}' for each in pictures}
    TopologicalSorter(graph).prepare()
