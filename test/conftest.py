"""What holds for all tests."""

from collections.abc import Callable
import os
from pathlib import Path
import sys
from typing import Any
import warnings

from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers
import numpy as np
import pytest
from recorded_launch import launch_file  # noqa: F401 (a fixture)

from billiard_shot import compiled, machine_code
from billiard_shot.compiler.build import provide

sys.path.append(str(Path(__file__).resolve().parents[1]))  # for the studies
NIGHTLY = 'NIGHTLY' in os.environ
# No limits of time: whether a machine is busy says nothing about the code. The same examples in
# every run; `make nightly` tries others, and more of them.
settings.register_profile(
    'patient',
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
    derandomize=not NIGHTLY,
    max_examples=1000 if NIGHTLY else 100,
)
settings.load_profile('patient')
if not NIGHTLY and hasattr(providers, '_get_local_constants'):
    # Hypothesis also draws constants that it reads in all modules which are loaded. The examples
    # of a test would then differ with the files that run beside it.
    NO_CONSTANTS = type(providers._local_constants)()
    providers._get_local_constants = lambda: NO_CONSTANTS


def pytest_sessionstart() -> None:
    """Run the library in the tests; if it is of other sources, build it. Check all calls."""
    if not machine_code.is_interpreting() and 'BILLIARD_SHOT_LIBRARY' not in os.environ:
        try:
            provide()
        except ModuleNotFoundError as error:
            warnings.warn(f'no library is built: {error.name} is not installed', stacklevel=1)
    compiled.argument_table = _checked_table_of


def _checked_table_of(arguments: list[dict[str, Any]], kept: int) -> Callable[..., bytes]:
    """Make a function that checks arguments before they are in a table; nobody else does."""
    table = _table_of(arguments, kept)

    def checked(*args: Any) -> bytes:
        for argument, value in zip(arguments, args, strict=True):
            check(argument, value)
        return table(*args)

    return checked


_table_of = compiled.argument_table
NUMBERS = {'f8': float, 'i8': (int, np.int64), 'b1': (bool, np.bool_)}


def check(argument: dict[str, Any], value: Any) -> None:
    """Check that a value is what the description of an argument states."""
    name, kind = argument['name'], argument['kind']
    if kind == 'tuple':
        for field, each in zip(argument['fields'], value, strict=True):
            check(field, each)
    elif kind == 'array':
        of, _, record = argument['of'].partition(':')
        dtype = getattr(sys.modules[of], record).dtype if record else np.dtype(of)
        assert isinstance(value, np.ndarray), name
        assert (value.ndim, value.dtype) == (argument['dimensions'], dtype), name
        assert value.flags.c_contiguous, name
        assert value.flags.behaved, f'{name} cannot be written'
    else:
        assert isinstance(value, NUMBERS[kind]), name
        assert isinstance(value, bool | np.bool_) == (kind == 'b1'), name


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the slow tests, so that the workers of `make test` end together."""
    items.sort(key=lambda item: item.get_closest_marker('slow') is None)
    for item in items:
        if item.get_closest_marker('nightly') and not NIGHTLY:
            item.add_marker(pytest.mark.skip('takes minutes: make nightly'))
