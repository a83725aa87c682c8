"""
An extension that reads docstrings in numpydoc form.

An attribute of a class that has no docstring of its own has a comment behind it in the source.
These comments become a list of attributes.
"""

from dataclasses import is_dataclass
from enum import Enum
import inspect
import re
from typing import Any

from sphinx.ext.napoleon import Config, NumpyDocstring

CONFIG = Config(napoleon_use_rtype=False, napoleon_use_ivar=True)
ATTRIBUTE = re.compile(r'^    ([A-Za-z]\w*)(?:: ([^=#]+?))?(?: = [^#]+?)?(?:  # (.*))?$')


ARRAY = re.compile(r'NDArray\[np\.([a-z]+)[\d_]*\]')


def attributes(kind: type) -> list[tuple[str, str, str]]:
    """Name, type and comment of the attributes that the source of a class declares."""
    found: list[list[str]] = []
    body = inspect.getsource(kind).split('"""', 2)[-1]
    for line in body.splitlines():
        if re.match('    (def|@)', line):
            break
        match = ATTRIBUTE.match(line)
        more = re.match(r'^    +# (.*)$', line)
        if match:
            found.append([match[1], ARRAY.sub(r'\1 array', match[2] or ''), match[3] or ''])
        elif more and found:
            found[-1][2] += f' {more[1]}'
    return [(name, annotation, comment) for name, annotation, comment in found]


def read(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Convert a docstring from numpydoc form to the form that Sphinx reads."""
    if what in ('property', 'attribute', 'data'):
        return  # in a single line, where a colon is just a colon
    documented = any(line in ('Parameters', 'Attributes') for line in lines)
    if what == 'class' and not documented and (is_dataclass(thing) or issubclass(thing, Enum)):
        lines += ['Attributes', '----------']
        for attribute, annotation, comment in attributes(thing):
            lines += [f'{attribute} : {annotation}' if annotation else attribute, f'    {comment}']
        lines.append('')
    lines[:] = NumpyDocstring('\n'.join(lines), CONFIG, app, what, name, thing, options).lines()


def hide(
    app: Any, what: str, name: str, thing: Any, options: Any, signature: str, returned: str
) -> tuple[str, str] | None:
    """Hide the constructors of results, because only the library makes results."""
    if what != 'class' or '.scene.' in thing.__module__:
        return None
    return None if 'Parameters\n' in (inspect.getdoc(thing) or '') else ('', '')


def setup(app: Any) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect('autodoc-process-docstring', read)
    app.connect('autodoc-process-signature', hide)
    return {'version': '1', 'parallel_read_safe': True}
