"""
YAML files with the line of each key.

1e-3 is a number, 8 and '8' are the same name, and a duplicate key is a mistake.
"""

from pathlib import Path
import re
from typing import Any, IO, NamedTuple

import yaml

from billiard_shot.scene.errors import InputError, Lines, Mistake, reason, TWICE
from billiard_shot.scene.errors import Path as Keys

MERGE = 'tag:yaml.org,2002:merge'  # <<, which copies the keys of another mapping


class Document(NamedTuple):
    """Content of a file, the lines of its keys (None without a file), and duplicate keys."""

    data: Any
    lines: Lines | None
    mistakes: list[Mistake]


class _Loader(yaml.SafeLoader):
    """Safe loader that follows YAML 1.2 for numbers, and records the line of each key."""

    def __init__(self, stream: IO[str]) -> None:
        super().__init__(stream)
        self.lines: dict[Keys, int] = {}
        self.mistakes: list[Mistake] = []
        self._seen: set[int] = set()

    def document(self) -> Document:
        """Read the whole document."""
        node = self.get_single_node()
        if node is None:
            return Document(None, {}, [])
        self._note(node, ())
        return Document(self.construct_document(node), self.lines, self.mistakes)

    def _note(self, node: yaml.Node, path: Keys) -> None:
        """Record the lines of a node and of all nodes below it; an aliased node only once."""
        self.lines.setdefault(path, node.start_mark.line + 1)
        if id(node) in self._seen:
            return
        self._seen.add(id(node))
        if isinstance(node, yaml.SequenceNode):
            for index, item in enumerate(node.value):
                self._note(item, (*path, str(index)))
        elif isinstance(node, yaml.MappingNode):
            self._note_keys(node, path)

    def _note_keys(self, node: yaml.MappingNode, path: Keys) -> None:
        for key_node, value in node.value:
            if not isinstance(key_node, yaml.ScalarNode) or key_node.tag == MERGE:
                continue  # not a plain key, or one that merges other keys
            key = (*path, str(self.construct_object(key_node)))
            line = key_node.start_mark.line + 1
            if key in self.lines:
                text = f'{TWICE}, first in line {self.lines[key]}'
                self.mistakes.append(Mistake(key, text, line))
            else:
                self.lines[key] = line
                self._note(value, key)


# YAML 1.1 also reads 010 as 8, 1:30 as 90, and 2024-01-01 as a date.
_INT, _FLOAT, _TIMESTAMP = (f'tag:yaml.org,2002:{kind}' for kind in ('int', 'float', 'timestamp'))
_Loader.yaml_implicit_resolvers = {
    first: [(tag, form) for tag, form in forms if tag not in (_INT, _FLOAT, _TIMESTAMP)]
    for first, forms in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_Loader.add_implicit_resolver(_INT, re.compile(r'[-+]?\d+$'), list('-+0123456789'))
_Loader.add_implicit_resolver(
    _FLOAT,
    re.compile(r'([-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$'),
    list('-+0123456789.'),
)


def _whole_number(loader: yaml.SafeLoader, node: Any) -> int:
    return int(str(loader.construct_scalar(node)))


_Loader.add_constructor(_INT, _whole_number)


def read_document(path: Path) -> Document:
    """
    Read a YAML file.

    Raises
    ------
    ValueError
        With file and position, if it cannot be read or is not YAML.

    """
    try:
        with path.open(encoding='utf-8') as file:
            loader = _Loader(file)
            try:
                return loader.document()
            finally:
                loader.dispose()
    except OSError as error:
        raise ValueError(f'{path}: {reason(error)}') from error
    except UnicodeDecodeError as error:
        raise ValueError(
            f'{path}: must be a text in UTF-8, got byte {error.object[error.start]:#04x} at '
            f'position {error.start}; save it with the encoding UTF-8'
        ) from error
    except yaml.MarkedYAMLError as error:
        mark, parts = error.problem_mark or error.context_mark, (error.context, error.problem)
        place = f'line {mark.line + 1}, column {mark.column + 1}: ' if mark else ''
        raise ValueError(f'{path}: {place}{": ".join(filter(None, parts))}') from error
    except (
        RecursionError,
        yaml.YAMLError,
        ValueError,  # of the encoding and, like those below, of a value with a tag: !!float x
        KeyError,
        AttributeError,
        TypeError,
    ) as error:
        raise ValueError(f'{path}: {" ".join(str(error).split())}') from error


def read_yaml(path: Path) -> Any:
    """Read a YAML file; ValueError also for duplicate keys."""
    data, lines, mistakes = read_document(path)
    if mistakes:
        raise InputError(mistakes, str(path), lines)
    return data
