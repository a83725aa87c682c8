"""The linters that `colcon test` usually runs, where they are installed."""

from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PATHS = [
    str(ROOT / name)
    for name in ('benchmarks', 'billiard_shot', 'docs', 'launch', 'setup.py', 'studies', 'test')
]
pytestmark = pytest.mark.skipif(
    not (ROOT / 'setup.cfg').exists(), reason='needs a source checkout'
)


def test_flake8():
    ament_flake8 = pytest.importorskip('ament_flake8.main', reason='needs ament_flake8')
    failed, errors = ament_flake8.main_with_errors(
        argv=['--config', str(ROOT / 'setup.cfg'), *PATHS]
    )
    assert not failed, '\n'.join(errors)


def test_pep257():
    """Without D402 and D417, which misunderstand numpydoc, and D401, which is ruff's."""
    ament_pep257 = pytest.importorskip('ament_pep257.main', reason='needs ament_pep257')
    assert ament_pep257.main(argv=[*PATHS, '--add-ignore', 'D401', 'D402', 'D417']) == 0
