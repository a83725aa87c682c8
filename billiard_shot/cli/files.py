"""Files that commands write: they can be written, have the right ending, and are no inputs."""

import argparse
from collections.abc import Iterator
import os
from pathlib import Path

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
