"""
Functions that run as machine code, or that Python interprets if there is no library of it.

The inner functions of the library are plain Python. `inner` and `innermost` note them for
`billiard_shot.compiler`. `Entry` is a function that other modules call.
"""

from collections.abc import Callable
import ctypes
from functools import cached_property
from operator import is_
import struct
import threading
from typing import Any, ParamSpec, Protocol, TypeVar

from billiard_shot import machine_code
from billiard_shot.records import OBJECTS, ROWS, Storage

P = ParamSpec('P')
R = TypeVar('R')

PARTS: dict[Callable[..., Any], bool] = {}
"""The inner functions, and whether each is inlined into every caller."""


def inner(function: Callable[P, R]) -> Callable[P, R]:
    """Note that a function is compiled, for other compiled functions. It must not make arrays."""
    PARTS[function] = False
    return function


def innermost(function: Callable[P, R]) -> Callable[P, R]:
    """Like `inner`, for the innermost loops: inlined into every caller."""
    PARTS[function] = True
    return function


class Run(Protocol):
    """An entry as it can be called now, and the storage that its arguments live in."""

    storage: Storage

    def __call__(self, *args: Any) -> Any:
        """Call the entry."""


class Interpreted:
    """An entry that Python interprets."""

    storage: Storage = OBJECTS

    def __init__(self, function: Callable[..., Any]) -> None:
        self.function = function

    def __call__(self, *args: Any) -> Any:
        """Call the entry."""
        return self.function(*args)


class Compiled:
    """
    An entry in machine code, which takes the address of a table of its arguments.

    Whether arguments have the types that the description states is not checked: it would take
    longer than the call. The tests check all calls.

    Parameters
    ----------
    function : ctypes function
    arguments : list of dict
        From the description of the library.
    kept : int
        See `entry`.

    """

    storage: Storage = ROWS

    def __init__(self, function: Any, arguments: list[dict[str, Any]], kept: int) -> None:
        function.argtypes, function.restype = [ctypes.c_char_p], ctypes.c_int64
        self.arguments = arguments
        self.function = function
        self.new = len(arguments) - kept
        self._pack_new = table_of(arguments[: self.new])
        self._pack_kept = table_of(arguments[self.new :])
        self._last = _Last()

    def __call__(self, *args: Any) -> Any:
        """Call the entry."""
        return self.function(self.table(*args))

    def table(self, *args: Any) -> bytes:
        """Put arguments into a table."""
        last, kept = self._last, args[self.new :]
        if last.table is None or not all(map(is_, kept, last.kept)):
            last.kept, last.table = kept, self._pack_kept(*kept)
        return self._pack_new(*args[: self.new]) + last.table


class _Last(threading.local):
    """The kept arguments of this thread's last call of an entry, and their part of the table."""

    kept: tuple[Any, ...] = ()
    table: bytes | None = None


class Entry:
    """
    A function that Python calls: machine code, or interpreted without it.

    Parameters
    ----------
    function : callable
    example : callable
        Makes arguments in a storage, which show their types.
    kept : int
        See `entry`.

    """

    def __init__(
        self,
        function: Callable[..., Any],
        example: Callable[[Storage], tuple[Any, ...]],
        kept: int = 0,
    ) -> None:
        self.function = function
        self.example = example
        self.kept = kept
        self.interpreted = Interpreted(function)
        self.__doc__ = function.__doc__

    def __call__(self, *args: Any) -> Any:
        """Call the entry from another function that is interpreted, or compiled as this one."""
        return self.function(*args)

    def current(self) -> Run:
        """Return the compiled function if there is a library, otherwise the interpreted one."""
        return self.compiled if machine_code.is_loaded() else self.interpreted

    def on(self, storage: Storage) -> Run:
        """Return the function that takes arguments in a storage."""
        return self.compiled if storage is ROWS else self.interpreted

    @cached_property
    def compiled(self) -> Compiled:
        """The function of the library."""
        library, name = machine_code.library(), self.function.__name__
        assert library is not None
        arguments = library.description['entries'][name]['arguments']
        return Compiled(library.functions[name], arguments, self.kept)


def entry(
    example: Callable[[Storage], tuple[Any, ...]], kept: int = 0
) -> Callable[[Callable[..., Any]], Entry]:
    """
    Make a function an `Entry`.

    The last `kept` of its arguments are put into the table anew only if they are not the objects
    of the last call in this thread: a table of 185 numbers takes longer than all else of a call.
    """
    return lambda function: Entry(function, example, kept)


_FORMATS = {'f8': 'd', 'i8': 'q', 'b1': '?7x'}  # of `struct`; a number takes eight bytes


def table_of(arguments: list[dict[str, Any]]) -> Callable[..., bytes]:
    """
    Make a function that puts arguments into a table.

    It is written for these arguments, and runs several times as fast as a loop over them. For an
    array, the table has its address and its shape. NumPy documents that the structure of an array
    begins with the address (`PyArrayObject.data`), after what all objects of CPython begin with;
    `array.ctypes.data` takes seven times as long.
    """
    values: list[str] = []
    formats: list[str] = []

    def name(argument: dict[str, Any]) -> str:
        """Name the variable of an argument, or those of all fields of a tuple."""
        if argument['kind'] == 'tuple':
            return f'({"".join(name(field) + ", " for field in argument["fields"])})'
        variable = f'x{argument["slot"]}'
        if argument['kind'] == 'array':
            values.append(f'address(id({variable}) + {object.__basicsize__}).value')
            values.append(f'*{variable}.shape')
            formats.append('Q' + 'q' * argument['dimensions'])
        else:
            values.append(variable)
            formats.append(_FORMATS[argument['kind']])
        return variable

    names = ''.join(f'{name(argument)}, ' for argument in arguments)
    code = f'def table(*args):\n ({names}) = args\n return pack({", ".join(values)})'
    made: dict[str, Any] = {
        'address': ctypes.c_size_t.from_address,
        'pack': struct.Struct(f'<{"".join(formats)}').pack,
    }
    exec(code, made)
    return made['table']
