"""
Arrays lent to compiled code that need not be counted.

numba counts the references to an array, atomically, at every look into a tuple of arrays and for
every row taken of one: half the time of a table. Whoever holds the array itself may lend it on
without; what is lent must not outlive it.
"""
from typing import Any

from numba.core import cgutils
from numba.extending import intrinsic, overload


def lent(array: Any) -> Any:
    """Return the same array, whose references nobody counts."""
    return array


_null: Any = cgutils.get_null_value


def _without_owner(_: Any, array: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        made = context.make_array(signature.args[0])(context, builder, arguments[0])
        made.meminfo = _null(made.meminfo.type)
        return made._getvalue()

    return array(array), generate


_stripped: Any = intrinsic(_without_owner)


@overload(lent)
def _lent(array: Any) -> Any:
    def lend(array: Any) -> Any:
        return _stripped(array)

    return lend
