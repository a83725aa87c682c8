"""What holds for all tests."""

import os
import sys
from typing import Any

from hypothesis import settings
import pytest
from recorded_launch import launch_file  # noqa: F401 (a fixture)

from billiard_shot import machine_code
from billiard_shot.compiled import Compiled

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
    """Run machine code in the tests where there can be any, and check the types of arguments."""
    if machine_code.require():
        Compiled.__call__ = _checked_call


_known: set[tuple[Any, ...]] = set()  # functions and kinds of their arguments


def _checked_call(entry: Compiled, *args: Any) -> Any:
    """Call an entry whose arguments have its types; nobody else checks this."""
    from numba import typeof  # which takes milliseconds
    from numba._dispatcher import compute_fingerprint

    kinds = entry.function, *map(compute_fingerprint, args)
    if kinds not in _known:
        assert tuple(map(typeof, args)) == entry.signature
        _known.add(kinds)
    return entry.run(*args)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the slow tests: the workers of `make test` end together."""
    items.sort(key=lambda item: item.get_closest_marker('slow') is None)
