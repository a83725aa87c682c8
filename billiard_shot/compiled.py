"""
Functions that Python interprets at first, and that run as machine code once it is loaded.

The inner functions of the library are plain Python. `inner` and `innermost` note how numba is to
compile a function into its callers. `Entry` is a function that other modules call. Nothing here
imports numba before machine code is asked for, so the first answer of a process does not wait for
it. `billiard_shot.machine_code` compiles the entries, once, in other processes.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from time import perf_counter
from typing import Any, ClassVar, ParamSpec, Protocol, TypeVar

from billiard_shot.records import OBJECTS, ROWS, Storage

P = ParamSpec('P')
R = TypeVar('R')

# Divisions follow IEEE 754, as in NumPy. Compiled code releases the GIL: threads run in parallel.
# `pipelines` adds what entries need besides. If entries had other options than inner functions,
# numba would compile the inner functions that both call once for each.
OPTIONS: dict[str, Any] = {
    'error_model': 'numpy',
    'nogil': True,
    'no_cpython_wrapper': True,
    'no_cfunc_wrapper': True,
    '_nrt': False,
}

_parts: list[tuple[Callable[..., Any], str]] = []
_callers: list[tuple[Callable[..., None], 'Entry']] = []


def inner(function: Callable[P, R]) -> Callable[P, R]:
    """
    Note that numba may compile a function into its callers.

    It must not make arrays. Without the counting of references that arrays need, it runs 1.2 to 2
    times as fast. (`register_jitable(_nrt=False)` is an example in numba's own documentation of
    `register_jitable`.)
    """
    _parts.append((function, 'Inner'))
    return function


def innermost(function: Callable[P, R]) -> Callable[P, R]:
    """Like `inner`, for the innermost loops: inlined into every caller."""
    _parts.append((function, 'Innermost'))
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
        result = function.overloads[signature]
        # numba's function for calls from C, which `_call_by_address` makes
        self.address: int = result.library.get_pointer_to_function(
            result.fndesc.llvm_cfunc_wrapper_name
        )

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
        Return the function for another entry to call by `caller`, if it returns nothing.

        Machine code calls it by its address, so that it is compiled once.
        """
        if storage is not ROWS:
            return self.function
        compiled = self.machine_code.get(self)
        return compiled.address if compiled is not None else 0

    def caller(self) -> Callable[..., None]:
        """Make a function that calls this entry, given `as_argument` and its arguments."""

        def call(function: Any, *args: Any) -> None:
            function(*args)

        _callers.append((call, self))
        return call

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

    from billiard_shot import pipelines

    for function, name in _parts:
        register_jitable(pipeline_class=getattr(pipelines, name), **OPTIONS)(function)
    _parts.clear()
    for call, called in _callers:
        _call_by_address(call, _argument_types(called))
    _callers.clear()
    with _cache_in(folder):
        compiler = numba.njit(cache=True, pipeline_class=pipelines.Outermost, **OPTIONS)
        function = compiler(entry.function)
    return Compiled(function, _argument_types(entry))


def _argument_types(entry: Entry) -> tuple[Any, ...]:
    """Return numba's types of the arguments of an entry."""
    import numba

    return tuple(map(numba.typeof, entry.example(ROWS)))


def _call_by_address(call: Callable[..., None], expected: tuple[Any, ...]) -> None:
    """Let compiled code call an entry with arguments of these types by its address."""
    from numba.core import types
    from numba.extending import intrinsic, overload

    cgutils: Any = import_module('numba.core.cgutils')  # these two have no types
    ir: Any = import_module('llvmlite.ir')

    def call_at(context: Any, address: Any, args: Any) -> Any:
        pairs = list(zip(args, expected, strict=True))
        assert all(context.can_convert(*pair) is not None for pair in pairs)

        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            given = cgutils.unpack_tuple(builder, values[1])
            converted = [
                context.cast(builder, value, *pair)
                for value, pair in zip(given, pairs, strict=True)
            ]
            function = ir.FunctionType(
                context.get_value_type(types.none), [each.type for each in converted]
            )
            builder.call(builder.inttoptr(values[0], function.as_pointer()), converted)
            return context.get_dummy_value()

        return types.none(address, args), generate

    compiled_call: Any = intrinsic(call_at)

    overload(call)(lambda function, *args: lambda function, *args: compiled_call(function, args))


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
