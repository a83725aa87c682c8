"""What holds for all tests."""

import os
import sys

from hypothesis import settings
import pytest
from recorded_launch import launch_file  # noqa: F401 (a fixture)

from billiard_shot import machine_code

NIGHTLY = 'NIGHTLY' in os.environ
if 'WITHOUT_NUMBA' in os.environ:
    sys.modules['numba'] = None  # as where it is not installed
# No deadline: whether a machine is busy says nothing about the code. The same examples in every
# run; `make nightly` tries others, and more of them.
settings.register_profile(
    'patient', deadline=None, derandomize=not NIGHTLY, max_examples=1000 if NIGHTLY else 100
)
settings.load_profile('patient')


def pytest_sessionstart() -> None:
    """Run machine code in the tests where there can be any."""
    machine_code.require()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the slow tests: the workers of `make test` end together."""
    items.sort(key=lambda item: item.get_closest_marker('slow') is None)
