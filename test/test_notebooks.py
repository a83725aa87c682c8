"""The notebooks of the documentation run, and are kept without what they print."""

import json
from pathlib import Path

import pytest

from billiard_shot import machine_code

NOTEBOOKS = sorted((Path(__file__).parents[1] / 'docs' / 'notebooks').glob('*.ipynb'))
CELLS = 12
FRAME = '<iframe srcdoc='


@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_are_short_and_stored_without_outputs(path):
    cells = json.loads(path.read_text(encoding='utf-8'))['cells']
    assert len(cells) <= CELLS
    assert all(not cell.get('outputs') and not cell.get('execution_count') for cell in cells)


@pytest.mark.skipif(not machine_code.is_loaded(), reason='needs machine code')
@pytest.mark.parametrize('path', NOTEBOOKS, ids=lambda path: path.stem)
def test_a_kernel_runs_the_notebooks(path, tmp_path):
    nbclient = pytest.importorskip('nbclient', reason='needs nbclient')
    pytest.importorskip('ipykernel', reason='needs ipykernel')
    pytest.importorskip('anywidget', reason='needs the extra notebook')
    nbformat = pytest.importorskip('nbformat')
    notebook = nbformat.read(path, 4)
    # a cell that raises makes `execute` raise
    done = nbclient.NotebookClient(notebook, resources={'metadata': {'path': tmp_path}}).execute()
    shown = [
        output.data.get('text/html', '')
        for cell in done.cells
        for output in cell.get('outputs', ())
        if 'data' in output
    ]
    live = 'TableWidget(' in path.read_text(encoding='utf-8')
    assert any(FRAME in html for html in shown) == live
