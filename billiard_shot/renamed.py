"""Former names of public classes, functions and attributes: they still work, with a warning."""

from collections.abc import Callable
import sys
from typing import Any, TypeVar
import warnings

C = TypeVar('C')


def former_attributes(**names: str) -> Callable[[type[C]], type[C]]:
    """Let objects of a class answer to former names of attributes, given as former=present."""

    def decorate(cls: type[C]) -> type[C]:
        for former, present in names.items():
            setattr(cls, former, _alias(cls.__name__, former, present))
        return cls

    return decorate


def former_members(module: str, **names: str) -> Callable[[str], Any]:
    """Return the `__getattr__` of a module whose members have former names, former=present."""

    def get(name: str) -> Any:
        if name not in names:
            raise AttributeError(f'module {module!r} has no attribute {name!r}')
        _warn(f'{module}.{name}', names[name])
        return getattr(sys.modules[module], names[name])

    return get


def _alias(owner: str, former: str, present: str) -> property:
    def get(self: Any) -> Any:
        _warn(f'{owner}.{former}', present)
        return getattr(self, present)

    return property(get, doc=f'Former name of `{present}`.')


def _warn(former: str, present: str) -> None:
    warnings.warn(
        f'{former} is a former name; it is now {present}', DeprecationWarning, stacklevel=3
    )
