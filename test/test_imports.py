"""No module imports itself through others, not even when a function runs."""

from graphlib import CycleError, TopologicalSorter

import grimp
import pytest

PACKAGE = 'billiard_shot'
PICTURES_OF_A_SHOT = ('canvas', 'table', 'view')  # which `Shot.plot` and `Shot.view` load


@pytest.fixture(scope='module')
def graph():
    found = grimp.build_graph(PACKAGE, exclude_type_checking_imports=True, cache_dir=None)
    return {module: found.find_modules_directly_imported_by(module) for module in found.modules}


def test_only_shots_import_what_imports_them(graph):
    pictures = {f'{PACKAGE}.pictures.{name}' for name in PICTURES_OF_A_SHOT}
    shot = f'{PACKAGE}.shot.shot'
    with pytest.raises(CycleError, match='cycle'):
        TopologicalSorter(graph).prepare()
    TopologicalSorter(graph | {shot: graph[shot] - pictures}).prepare()
