"""Objects that notebooks show with a picture and a table."""

from collections.abc import Callable
from typing import ClassVar


class Shown:
    """An object that notebooks show as HTML."""

    __slots__ = ()
    html_of: ClassVar[Callable[[object], str]]  # set by the package, which knows the pictures

    def _repr_html_(self) -> str:
        return type(self).html_of(self)
