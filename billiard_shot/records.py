"""
Records: plain objects while Python runs the library, rows of an array for machine code.

A record is a class whose annotations name its fields. Functions read and write `ball.time` or
`ball.position[0]`, and run alike on both: interpreted, attributes of an object are fourteen times
as fast as fields of a NumPy record; compiled, only rows of an array exist.

Three rules keep the two alike. A vector is changed element by element. A record is never copied or
swapped, only its fields are. The caller of compiled code keeps the arrays alive.
"""

from collections.abc import Sequence
from functools import cached_property
from operator import attrgetter
from typing import Annotated, Any, get_args, get_origin, get_type_hints, Protocol, TypeVar

import numpy as np
from numpy.typing import DTypeLike, NDArray

R = TypeVar('R')

Array = NDArray[np.float64]
"""An array of numbers outside compiled code."""
Triple = tuple[float, float, float]
"""Three numbers outside compiled code, such as a position along the axes of a frame."""
Vector = Sequence[float] | NDArray[np.float64]
"""A one-dimensional array of compiled code; interpreted, a list of floats."""
Floats = Any
"""An array that is written to. mypy has no type that is a list and an array."""
Vector3 = Annotated[Any, 3]
"""Three numbers in a record, along the axes of a frame."""
_KINDS: dict[Any, str] = {float: 'f8', int: 'i8', bool: '?'}
_ZEROS = {float: '0.0', int: '0', bool: 'False'}


def record(cls: type[R]) -> type[R]:
    """
    Make a class of annotations a record: with slots, all of them zero, and with a `dtype`.

    A record has the fields of all classes that its class inherits, but is no subclass of these. At
    most one of them is a record.
    """
    kinds = get_type_hints(cls, include_extras=True)
    lines: list[str] = ['def __init__(self):']
    fields: list[Any] = []
    for name, kind in kinds.items():
        if get_origin(kind) in (Annotated, tuple):
            size = get_args(kind)[1] if get_origin(kind) is Annotated else len(get_args(kind))
            fields.append((name, 'f8', (size,)))
            lines.append(f' self.{name} = [0.0] * {size}')
        else:
            fields.append((name, _KINDS[kind]))
            lines.append(f' self.{name} = {_ZEROS[kind]}')
    made: dict[str, Any] = {}
    exec('\n'.join(lines), made)
    body = {
        '__slots__': tuple(kinds),
        '__init__': made['__init__'],
        '__annotations__': kinds,
        '__doc__': cls.__doc__,
        '__module__': cls.__module__,
        '__qualname__': cls.__qualname__,
    }
    slotted: Any = type(cls.__name__, (), body)
    slotted.dtype = np.dtype((np.record, np.dtype(fields, align=True)))
    return slotted


def record_layout(kind: type) -> dict[str, Any]:
    """Describe the bytes of a record: its size, and name, offset, kind and shape of each field."""
    dtype: np.dtype[np.void] = kind.dtype  # type: ignore[attr-defined]
    fields = []
    for name in dtype.names or ():
        field, offset = dtype.fields[name][:2]  # type: ignore[index]
        fields.append(
            {
                'name': name,
                'offset': offset,
                'kind': storage_kind(field.base),
                'shape': list(field.shape),
            }
        )
    return {'size': dtype.itemsize, 'fields': fields}


def storage_kind(dtype: np.dtype[Any]) -> str:
    """Name the kind of a number: f8, i8 or b1."""
    return f'{dtype.kind}{dtype.itemsize}'


class Storage(Protocol):
    """Storage of records and arrays: in objects and lists, or in arrays."""

    def __hash__(self) -> int:
        """Return a hash, for functions with a cache."""

    def records(self, kind: type[R], count: int) -> Any:
        """Return new records, all fields zero."""

    def unset(self, kind: type[R], count: int) -> Any:
        """Return new records that are written before they are read."""

    def from_rows(self, kind: type[R], rows: NDArray[np.void]) -> Any:
        """Return rows of an array as records; they may be the rows themselves."""

    def array(self, values: Any) -> Any:
        """Return numbers, of any shape, as functions take them."""

    def zeros(self, *shape: int) -> Any:
        """Return zeros of a shape."""


class Objects:
    """Storage of functions that Python interprets."""

    def records(self, kind: type[R], count: int) -> list[R]:
        """Return new records, all fields zero."""
        return [kind() for _ in range(count)]

    unset = records

    def from_rows(self, kind: type[R], rows: NDArray[np.void]) -> list[R]:
        """Return rows of an array as new records."""
        records = self.records(kind, len(rows))
        for made, row in zip(records, rows.tolist(), strict=True):
            for name, value in zip(rows.dtype.names or (), row, strict=True):
                setattr(made, name, value.tolist() if isinstance(value, np.ndarray) else value)
        return records

    def array(self, values: Any) -> Any:
        """Return numbers as a list, of lists if they have several dimensions."""
        return np.asarray(values).tolist()

    def zeros(self, *shape: int) -> Any:
        """Return zeros as a list, of lists if there are several dimensions."""
        if len(shape) == 1:
            return [0.0] * shape[0]
        return [self.zeros(*shape[1:]) for _ in range(shape[0])]


class Rows:
    """Storage of functions that are compiled."""

    def records(self, kind: type[R], count: int) -> NDArray[np.void]:
        """Return new records, all fields zero."""
        dtype: np.dtype[np.void] = kind.dtype  # type: ignore[attr-defined]
        return np.zeros(count, dtype)

    def unset(self, kind: type[R], count: int) -> NDArray[np.void]:
        """Return new records that are written before they are read."""
        dtype: np.dtype[np.void] = kind.dtype  # type: ignore[attr-defined]
        return np.empty(count, dtype)

    def from_rows(self, kind: type[R], rows: NDArray[np.void]) -> NDArray[np.void]:
        """Return the rows, one after the other in memory."""
        return np.ascontiguousarray(rows)

    def array(self, values: Any) -> NDArray[Any]:
        """Return numbers as an array of floats or whole numbers."""
        array = np.ascontiguousarray(values)
        if array.dtype != np.int64:
            array = array.astype(np.float64, copy=False)
        return array if array.flags.writeable else array.copy()  # that one has another type

    def zeros(self, *shape: int) -> NDArray[np.float64]:
        """Return zeros of a shape."""
        return np.zeros(shape)


OBJECTS, ROWS = Objects(), Rows()


def as_rows(kind: type[R], records: Any) -> NDArray[np.void]:
    """Return records as rows of an array; rows as they are."""
    if isinstance(records, np.ndarray):
        return records
    dtype: np.dtype[np.void] = kind.dtype  # type: ignore[attr-defined]
    rows = np.zeros(len(records), dtype)
    for name in dtype.names or ():
        if len(records):
            rows[name] = [getattr(each, name) for each in records]
    return rows


def column(
    rows: str, name: str | None = None, kind: DTypeLike | None = None
) -> cached_property[NDArray[Any]]:
    """
    Make a property of a class that has rows: one of their fields as an array.

    Parameters
    ----------
    rows : str
        The attribute of an object that has the rows, with points for attributes of attributes.
    name : str, optional
        The field; by default the property is the rows themselves.
    kind : dtype, optional
        Of the array; by default that of the field, without a copy.

    """
    found = attrgetter(rows)

    def values(owner: object) -> NDArray[Any]:
        column = found(owner) if name is None else found(owner)[name]
        return column if kind is None else column.astype(kind)

    return cached_property(values)
