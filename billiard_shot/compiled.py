"""Decorators for compiled functions: the same options for all, and one safe cache."""

from collections.abc import Callable
from functools import cache
import hashlib
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba
import numba.extending

P = ParamSpec('P')
R = TypeVar('R')

# Divisions follow IEEE 754, as in NumPy; the GIL is released, so that threads work in parallel.
OPTIONS: dict[str, Any] = {'error_model': 'numpy', 'nogil': True}
INNER = {**OPTIONS, 'no_cfunc_wrapper': True}  # nobody calls these from C either
ROOMS = ('impact', 'table', 'shot')  # where compiled functions live


@cache
def sources_digest() -> str:
    """Digest of the sources of all compiled functions."""
    here = Path(__file__).parent
    digest = hashlib.sha256()
    for path in sorted(path for room in ROOMS for path in (here / room).glob('*.py')):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _part(function: Callable[P, R], **options: bool) -> Callable[P, R]:
    """Register a function that numba compiles inside its callers, and that is Python elsewhere."""
    jit: Any = numba.extending.register_jitable
    registered: Callable[P, R] = jit(**INNER, **options)(function)
    return registered


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """
    Let numba compile a function of scalars and arrays as a part of the entries that call it.

    Called from Python, it stays a Python function: nothing is compiled that would let Python in,
    which saves about a quarter of the first prediction's compile time.
    """
    return _part(function)


def frugal(function: Callable[P, R]) -> Callable[P, R]:
    """
    Like `compiled`, for a function that makes no arrays, nor calls one that does.

    Without the counting of references that arrays need it runs a quarter faster, and compiles
    faster too.
    """
    return _part(function, _nrt=False)


def melted(function: Callable[P, R]) -> Callable[P, R]:
    """
    Like `frugal`, for what the innermost loops call: melted into it, without a call.

    A strike is a quarter faster for it, and the first prediction's compile time a tenth longer.
    """
    return _part(function, _nrt=False, forceinline=True)


def fused(function: Callable[P, R]) -> Callable[P, R]:
    """
    Compile a function as `compiled` does, and melt it into all that call it.

    For small functions that pass tuples of arrays around, whose many words would be copied at
    every call.
    """
    return _part(function, forceinline=True)


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """
    Compile a function as a piece of its only caller.

    The code generator works through all that a function calls once for each level of calls; for a
    function that calls nearly everything, with one caller, the level is not worth the seconds.
    """
    dispatcher: Any = numba.njit(inline='always', **OPTIONS)(function)
    return dispatcher


def entry(function: Callable[P, R]) -> Callable[P, R]:
    """
    Compile a function that Python calls, with all that it calls, and keep the result on disk.

    numba takes a cached result for fresh while the function's own file is unchanged, even where
    a function that it calls was edited in another file; here every source counts.
    """
    dispatcher: Any = numba.njit(cache=True, **OPTIONS)(function)
    file: Any = getattr(getattr(dispatcher, '_cache', None), '_cache_file', None)
    if hasattr(file, '_source_stamp'):
        file._source_stamp = sources_digest()
    return dispatcher
