"""No module imports itself through others, not even for types or when a function runs."""

from graphlib import TopologicalSorter

import grimp

PACKAGE = 'billiard_shot'


def test_no_module_imports_itself():
    graph = grimp.build_graph(PACKAGE, cache_dir=None)
    imports = {each: graph.find_modules_directly_imported_by(each) for each in graph.modules}
    assert len(imports) > 100
    TopologicalSorter(imports).prepare()  # raises CycleError
