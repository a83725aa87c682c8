"""
Functions that Python interprets at first, and that run as machine code once it is loaded.

The inner functions of the library are plain Python. `inner` and `innermost` note how numba is to
compile a function into its callers. `Entry` is a function that other modules call. Nothing here
imports numba before machine code is asked for, so the first answer of a process does not wait for
it. `billiard_shot.machine_code` compiles the entries, once, in other processes.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Any, ClassVar, ParamSpec, Protocol, TypeVar

from billiard_shot.records import OBJECTS, ROWS, Storage

P = ParamSpec('P')
R = TypeVar('R')

# Divisions follow IEEE 754, as in NumPy. Compiled code releases the GIL: threads run in parallel.
OPTIONS: dict[str, Any] = {'error_model': 'numpy', 'nogil': True}
# No wrapper for calls from C, which are never made: it takes a fifth of the compile time.
INNER: dict[str, Any] = {**OPTIONS, 'no_cfunc_wrapper': True}

_parts: list[tuple[Callable[..., Any], dict[str, bool]]] = []


def inner(function: Callable[P, R]) -> Callable[P, R]:
    """
    Note that numba may compile a function into its callers.

    It must not make arrays. Without the counting of references that arrays need, it runs 1.2 to 2
    times as fast. (`register_jitable(_nrt=False)` is an example in numba's own documentation of
    `register_jitable`.)
    """
    return _note(function, _nrt=False)


def innermost(function: Callable[P, R]) -> Callable[P, R]:
    """Like `inner`, for the innermost loops: inlined into every caller."""
    return _note(function, _nrt=False, forceinline=True)


def _note(function: Callable[P, R], **options: bool) -> Callable[P, R]:
    _parts.append((function, options))
    return function


class Run(Protocol):
    """An entry as it can be called now, and the storage that its arguments live in."""

    storage: Storage

    def __call__(self, *args: Any) -> Any:
        """Call the entry."""


class Interpreted:
    """An entry that Python interprets."""

    storage: Storage = OBJECTS
    seconds = 0.0  # of all entries so far
    # Called with these seconds before an entry is interpreted; `machine_code` is one.
    listeners: ClassVar[list[Callable[[float], None]]] = []

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function

    def __call__(self, *args: Any) -> Any:
        """Call the entry, and note for how long it runs."""
        begin = perf_counter()
        try:
            return self.function(*args)
        finally:
            Interpreted.seconds += perf_counter() - begin


class Compiled:
    """
    An entry in machine code.

    numba finds out the types of all arguments for each call, which takes up to four times as long
    as passing them. An entry has one signature, so a call passes its arguments directly. They must
    have the types of the example, and arrays its number of dimensions; the tests check all calls.

    Parameters
    ----------
    function : callable
        numba's function.
    signature : tuple
        numba's types of the arguments.

    """

    storage: Storage = ROWS

    def __init__(self, function: Any, signature: tuple[Any, ...]) -> None:
        self.function = function
        self.signature = signature
        self.run: Callable[..., Any] = function.compile(signature)

    def __call__(self, *args: Any) -> Any:
        """Call the entry."""
        return self.run(*args)


class Entry:
    """
    A function that Python calls: interpreted until its machine code is loaded.

    An entry calls another entry only as an argument, see `as_argument`; other code that two of
    them need is `inner`.

    Parameters
    ----------
    function : callable
    example : callable
        Makes arguments in a storage, from which numba learns their types.

    """

    machine_code: ClassVar[dict['Entry', Compiled]] = {}  # of all entries, or empty

    def __init__(
        self, function: Callable[..., Any], example: Callable[[Storage], tuple[Any, ...]]
    ) -> None:
        self.function = function
        self.example = example
        self.interpreted = Interpreted(function)
        self.__doc__ = function.__doc__

    def current(self) -> Run:
        """Return the compiled function if it is loaded, otherwise the interpreted one."""
        compiled = self.machine_code.get(self)
        if compiled is not None:
            return compiled
        for listen in Interpreted.listeners:
            listen(Interpreted.seconds)
        return self.interpreted

    def as_argument(self, storage: Storage) -> Any:
        """
        Return the function for another entry to call, if it returns nothing.

        Machine code calls it by its address, so that it is compiled once.
        """
        return _address_of(self) if storage is ROWS else self.function

    def on(self, storage: Storage) -> Run:
        """Return the function that takes arguments in a storage."""
        return self.machine_code[self] if storage is ROWS else self.interpreted


def entry(example: Callable[[Storage], tuple[Any, ...]]) -> Callable[[Callable[..., Any]], Entry]:
    """Make a function an `Entry`."""
    return lambda function: Entry(function, example)


def compile_entry(entry: Entry, folder: Path) -> Compiled:
    """
    Compile an entry or, if its folder has its machine code already, load it.

    Parameters
    ----------
    entry : Entry
    folder : Path
        Of this entry alone, named after everything that its machine code depends on.

    Returns
    -------
    Compiled

    Raises
    ------
    Exception
        Whatever numba raises, for example for a damaged file in the folder.

    """
    import numba
    from numba.extending import register_jitable

    for function, options in _parts:
        register_jitable(**INNER, **options)(function)
    _parts.clear()
    with _cache_in(folder):
        function = numba.njit(cache=True, **OPTIONS)(entry.function)
    return Compiled(function, _argument_types(entry))


def _argument_types(entry: Entry) -> tuple[Any, ...]:
    """Return numba's types of the arguments of an entry."""
    import numba

    return tuple(map(numba.typeof, entry.example(ROWS)))


@cache
def _address_of(entry: Entry) -> Any:
    """Make the machine code of an entry an argument of numba's type of functions."""
    import numba

    import_module('numba.experimental.function_type')  # which knows the type of such arguments

    class Address(numba.types.WrapperAddressProtocol):
        """Gives the address of the machine code, once it is loaded, and its signature."""

        def __wrapper_address__(self) -> int:
            return address()

        def signature(self) -> Any:
            return signature

    signature = numba.void(*_argument_types(entry))

    @cache
    def address() -> int:
        function: Any = entry.machine_code[entry].function
        result = function.get_compile_result(signature)
        found: int = result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name)
        return found

    return Address()


@contextmanager
def _cache_in(folder: Path) -> Iterator[None]:
    """
    Let numba keep its machine code in this folder.

    numba's own locators depend on the path of the source file, so that each installation compiles
    again. The list of locators is the one hook that all supported versions of numba have.
    """
    caching: Any = import_module('numba.core.caching')  # it has no types
    config: Any = import_module('numba.core.config')

    class Locator(caching._CacheLocator):  # type: ignore[misc]
        """Names the folder; the folder's own name says which sources it belongs to."""

        @classmethod
        def from_function(cls, py_func: Callable[..., Any], py_file: str) -> 'Locator':
            del py_func, py_file
            return cls()

        def get_cache_path(self) -> str:
            return str(folder)

        def get_source_stamp(self) -> str:
            return ''

        def get_disambiguator(self) -> str:
            return ''

    before = caching.CacheImpl._locator_classes, getattr(config, 'CACHE_LOCATOR_CLASSES', '')
    caching.CacheImpl._locator_classes, config.CACHE_LOCATOR_CLASSES = [Locator], ''
    try:
        yield
    finally:
        caching.CacheImpl._locator_classes, config.CACHE_LOCATOR_CLASSES = before
