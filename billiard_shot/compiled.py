"""Decorators for compiled functions, so that they all share the same options."""
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numba

P = ParamSpec('P')
R = TypeVar('R')

# Divisions follow IEEE 754, as in NumPy, and the GIL is released, so that threads work in parallel.
OPTIONS = {'error_model': 'numpy', 'nogil': True}


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """
    Compile a function of scalars and arrays with numba, as a part of the entries that call it.

    With `NUMBA_DISABLE_JIT=1` the same functions run as plain Python.
    """
    return numba.njit(**OPTIONS)(function)  # type: ignore[no-any-return]


def entry(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that Python calls, with all that it calls, and keep the result on disk."""
    return numba.njit(cache=True, **OPTIONS)(function)  # type: ignore[no-any-return]
