"""Games and players: modules of a folder of the package, found by their names, or of others."""

from importlib import import_module
from pathlib import Path
from typing import Any

from billiard_shot.scene.errors import InputError, Mistake, refused, suggestion


def names_in(folder: str) -> list[str]:
    """Names of the modules of a folder of this package, in alphabetical order."""
    return sorted(path.stem for path in Path(__file__).with_name(folder).glob('[a-z]*.py'))


def find_plugin(name: str, folder: str, attribute: str, what: str) -> Any:
    """
    Return the attribute of a module.

    Parameters
    ----------
    name : str
        One of `names_in(folder)`; or `package.module`, a module of somebody else.
    folder, attribute : str
    what : str
        What the module defines, in one word: the field that messages name; '' for none.

    Raises
    ------
    ValueError
        If there is no such module, or it has no such attribute.

    """
    names = names_in(folder)
    if name in names:
        name = f'billiard_shot.game.{folder}.{name}'
    elif '.' not in name or not all(map(str.isidentifier, name.split('.'))):
        allowed = f'one of {", ".join(names)}, or a module such as package.module'
        raise refused(name, allowed, what, hint=suggestion(names, name))
    try:
        return getattr(import_module(name), attribute)
    except (ImportError, AttributeError) as error:
        text = f': {name!r} is not a module with {attribute}: {error}'
        raise InputError([Mistake((what,) if what else (), text)]) from None
