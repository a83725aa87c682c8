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
from typing import Any, NamedTuple, ParamSpec, TypeVar

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


class Run(NamedTuple):
    """An entry as it can be called now, and the storage that its arguments live in."""

    storage: Storage
    function: Callable[..., Any]

    def __call__(self, *args: Any) -> Any:
        """Call the entry."""
        return self.function(*args)


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
        self.interpreted = Run(OBJECTS, function)
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
    def compiled(self) -> Run:
        """
        The function of the library.

        It does not check its arguments, which would take longer than the call: they must be what
        the description of the library states. The tests check all calls.
        """
        library, name = machine_code.library(), self.function.__name__
        assert library is not None
        function = library.functions[name]
        function.argtypes, function.restype = [ctypes.c_char_p], ctypes.c_int64
        table = argument_table(library.description['entries'][name]['arguments'], self.kept)
        return Run(ROWS, lambda *args: function(table(*args)))


def entry(
    example: Callable[[Storage], tuple[Any, ...]], kept: int = 0
) -> Callable[[Callable[..., Any]], Entry]:
    """
    Make a function an `Entry`.

    The last `kept` of its arguments are put into the table anew only if they are not the objects
    of the last call in this thread: a table of 185 numbers takes longer than all else of a call.
    """
    return lambda function: Entry(function, example, kept)


def argument_table(arguments: list[dict[str, Any]], kept: int) -> Callable[..., bytes]:
    """Make a function that puts arguments into a table; the last are kept, see `entry`."""
    new = len(arguments) - kept
    pack_new, pack_kept = packer(arguments[:new]), packer(arguments[new:])
    last = threading.local()

    def table(*args: Any) -> bytes:
        same = args[new:]
        if not hasattr(last, 'part') or not all(map(is_, same, last.arguments)):
            last.arguments, last.part = same, pack_kept(*same)
        part: bytes = last.part
        return pack_new(*args[:new]) + part

    return table


_FORMATS = {'f8': 'd', 'i8': 'q', 'b1': '?7x'}  # of `struct`; a number takes eight bytes


def packer(arguments: list[dict[str, Any]]) -> Callable[..., bytes]:
    """
    Make a function that packs arguments into a table.

    It is written for these arguments, and runs several times as fast as a loop over them. For an
    array, the table has its address and its shape. NumPy documents that the structure of an array
    begins with the address (`PyArrayObject.data`), after the head that all objects of CPython
    have; `array.ctypes.data` takes seven times as long.
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
    made: dict[str, Any] = {
        'address': ctypes.c_size_t.from_address,
        'pack': struct.Struct(f'<{"".join(formats)}').pack,
    }
    exec(f'def packed(*args):\n ({names}) = args\n return pack({", ".join(values)})', made)
    return made['packed']
