"""One decorator for every compiled function, so that they all share the same options."""
from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numba

P = ParamSpec('P')
R = TypeVar('R')


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """
    Compile a function of scalars and arrays with numba, and keep the result on disk.

    With `NUMBA_DISABLE_JIT=1` the same functions run as plain Python. Divisions follow IEEE 754,
    as in NumPy (`error_model`), and the GIL is released, so that threads work in parallel.
    """
    return numba.njit(cache=True, error_model='numpy', nogil=True)(function)  # type: ignore[no-any-return]
