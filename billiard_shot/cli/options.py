"""
Options of commands: fields of dataclasses, as parameters of nodes are; and the files they name.

The docstring of such a dataclass has the metavar of each field as its type, and its help, in which
`%(default)s`, `%(choices)s` and the names of other attributes stand for their values. A field that
the docstring leaves out is hidden. The type of a field says how many values it takes; its range,
as in scenes, which are allowed. The values of an instance are the defaults.

Files that commands write can be written, have the right ending, and are not inputs.
"""

import argparse
from collections.abc import Callable, Iterator
import dataclasses
import os
from pathlib import Path
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints, NamedTuple

from billiard_shot.scene.fields import Description, descriptions, TAKES

FLAGS, HOW, CONSTANT = 'flags', 'how', 'constant'


class Subcommand(NamedTuple):
    """A command of a module that has several, beside modules that are a command each."""

    OPTIONS: tuple[Any, ...]
    run: Callable[[argparse.Namespace], int]


def option(*flags: str, default: Any = None, **how: Any) -> Any:
    """Field for an option with more flags, such as -o, or with arguments of `add_argument`."""
    return dataclasses.field(default=default, metadata={FLAGS: flags, HOW: how})


def positional(nargs: str | None = None, **how: Any) -> Any:
    """Field for a value that has a place instead of a name."""
    return dataclasses.field(default=None, metadata={FLAGS: None, HOW: {'nargs': nargs} | how})


def constant(default: Any = None) -> Any:
    """Field for a value that is no option; commands read it as if it were one."""
    return dataclasses.field(default=default, metadata={CONSTANT: True})


def add_options(parser: argparse.ArgumentParser, *groups: Any) -> None:
    """
    Add the options of instances of dataclasses.

    `TITLE` of a dataclass is the heading of its options; of one that is `EXCLUSIVE` only one
    option may be given.
    """
    for group in groups:
        into: Any = parser
        if title := getattr(group, 'TITLE', ''):
            into = parser.add_argument_group(title)
        elif getattr(group, 'EXCLUSIVE', False):
            into = parser.add_mutually_exclusive_group()
        types, words = get_type_hints(type(group)), descriptions(type(group))
        values = {name: getattr(group, name) for name in dir(group)}
        for field in dataclasses.fields(group):
            if CONSTANT in field.metadata:
                parser.set_defaults(**{field.name: values[field.name]})
                continue
            how = {'default': values[field.name], **_taken(types[field.name])}
            how |= field.metadata.get(HOW, {})
            how |= _said(words.get(field.name), values | how)
            action = into.add_argument(*_flags(field), **how)
            action.takes = field.metadata.get(TAKES)


def _flags(field: 'dataclasses.Field[Any]') -> tuple[str, ...]:
    """Return the flags of an option, or the name of a positional value."""
    name = field.name.rstrip('_')  # Python has taken the name `pass`
    flags = field.metadata.get(FLAGS, ())
    if flags is None:
        return (name,)
    if any(flag.startswith('--') for flag in flags):
        return tuple(flags)
    return *flags, f'--{name.replace("_", "-")}'


def _said(words: Description | None, values: dict[str, Any]) -> dict[str, Any]:
    """Take metavar and help from a description."""
    if words is None:
        return {'help': argparse.SUPPRESS}
    text = words.text.removesuffix('.')
    text %= values | {'choices': ', '.join(values.get('choices', ()))}
    if not text[1:2].isupper():
        text = text[0].lower() + text[1:]
    said: dict[str, Any] = {'help': text.replace('%', '%%')}
    if words.kind[0].isupper():
        names = tuple(words.kind.split())
        said['metavar'] = names if len(names) > 1 else words.kind
    return said


def _taken(kind: Any) -> dict[str, Any]:
    """Say to argparse how many values an option takes, and of which type."""
    if isinstance(kind, UnionType):  # `... | None`
        kind = get_args(kind)[0]
    if kind is bool:
        return {'action': 'store_true'}
    if get_origin(kind) is list:
        return {'nargs': '+', 'type': get_args(kind)[0]}
    if get_origin(kind) is tuple:
        return {'nargs': len(get_args(kind)), 'type': get_args(kind)[0]}
    return {'type': kind}


def check_options(options: argparse.Namespace, parser: argparse.ArgumentParser) -> None:
    """Raise ValueError, naming the option, if a value is out of the range of its field."""
    for action in parser._actions:
        takes, value = getattr(action, TAKES, None), getattr(options, action.dest, None)
        if takes and value is not None:
            try:
                takes(value)
            except ValueError as error:
                raise ValueError(f'{action.option_strings[-1]} {error}') from None


PICTURES = 'picture', 'history', 'close_up'
"""Options that name a file to draw."""

WRITTEN = *PICTURES, 'output', 'view', 'video', 'state', 'report', 'errors'
"""Options that name a file to write."""

ENDINGS = {'.png': ('.png', '.svg', '.pdf', '.jpg'), '.yaml': ('.yaml', '.yml')}
"""Endings that stand for others of their kind."""

UNNAMED = '.json', '.csv', '.yaml'
"""Endings that may also be left out."""

UNCHECKED = '', '.gif', '.jsonl'
"""Endings of files that commands check themselves, or continue."""


def check_files(options: argparse.Namespace) -> None:
    """
    Check the files that a command writes.

    Raises
    ------
    ValueError
        If a file is a folder, is in no folder, has the ending of another kind, or is one that the
        command reads, or writes for another option.

    """
    read = {path: f'{name} reads' for path, name in _inputs(options)}
    for action in options.parser._actions:
        path = getattr(options, action.dest, None)
        if action.dest not in WRITTEN or not path:
            continue
        option = f'--{action.dest.replace("_", "-")}'
        if path.is_dir():
            raise ValueError(f'{option} must be a file, not a folder, got {path}')
        if not path.absolute().parent.is_dir():
            raise ValueError(f'{option} must be in a folder that exists, got {path}')
        ending = Path(str(action.metavar)).suffix
        kinds = ENDINGS.get(ending, (ending,))
        allowed = (*kinds, '') if ending in UNNAMED else kinds
        if ending not in UNCHECKED and path.suffix not in allowed:
            raise ValueError(f'{option} must be a file {" or ".join(kinds)}, got {path}')
        for other, use in read.items():
            if _is_same(path, other):
                raise ValueError(f'{option} must be another file than {use}, got {path}')
        if not _is_device(path):
            read[path] = f'{option} writes'


def _inputs(options: argparse.Namespace) -> Iterator[tuple[Path, str]]:
    """Yield the files that a command reads, and the arguments that name them."""
    for action in options.parser._actions:
        given = getattr(options, action.dest, None)
        if action.dest in WRITTEN or given is None:
            continue
        name = action.option_strings[-1] if action.option_strings else str(action.metavar)
        for each in given if isinstance(given, list) else [given]:
            if isinstance(each, str | Path) and Path(each).is_file():
                yield Path(each), name
                if isinstance(each, Path) and each.suffix in ('.csv', '.json'):
                    yield each.with_suffix('.yaml'), f'the description that {name}'


def _is_same(one: Path, other: Path) -> bool:
    if one.exists() and other.exists():
        return os.path.samefile(one, other)
    return one.resolve() == other.resolve()


def _is_device(path: Path) -> bool:
    """Whether a path is no regular file, such as /dev/stdout: it may be written twice."""
    return path.exists() and not path.is_file()
