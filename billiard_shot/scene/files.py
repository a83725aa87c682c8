"""Files of scenes: the bundled ones, YAML with the line of each key, and inheritance by `like`."""

from collections.abc import Mapping
from pathlib import Path
import re
from typing import Any, IO, NamedTuple

import yaml

from billiard_shot.scene.errors import (
    found_in,
    InputError,
    Lines,
    Mistake,
    must_be,
    must_be_one_of,
    reason,
    refused,
    TWICE,
)
from billiard_shot.scene.errors import Path as Keys

_PACKAGE = Path(__file__).resolve().parents[1]
_FOLDERS = (_PACKAGE / 'scenes', _PACKAGE.parent / 'config' / 'scenes')


def scene_names() -> list[str]:
    """Names of the bundled scenes, in alphabetical order."""
    return sorted(path.stem for path in _folder().glob('*.yaml'))


def scene_path(name: str) -> Path:
    """
    Path of the bundled scene `name`.

    Raises
    ------
    ValueError
        If there is no such scene; the message has the nearest name, or all names.

    """
    names = scene_names()
    if name not in names:
        raise ValueError(f'scene {must_be_one_of(names, name)}')
    return _folder() / f'{name}.yaml'


def find_scene(name_or_path: str | Path, folder: Path = Path()) -> Path:
    """
    Path of a scene from a Path, a string with a folder or an ending, or the name of a bundled one.

    Relative paths are relative to `folder`.

    Raises
    ------
    ValueError
        If there is no such bundled scene, or if the ending is not that of a scene.

    """
    text = str(name_or_path)
    suffix = Path(text).suffix
    if suffix not in ('', '.yaml', '.yml'):
        raise refused(text, 'a bundled scene or a .yaml file', 'scene')
    is_file = isinstance(name_or_path, Path) or suffix != ''
    return folder / text if is_file or Path(text).name != text else scene_path(text)


def _folder() -> Path:
    return next((folder for folder in _FOLDERS if folder.is_dir()), _FOLDERS[-1])


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


LIKE = 'like'
# Contacts that have either of two keys: the one that is given replaces the one that is inherited.
EITHER = {'stiffness': 'duration', 'duration': 'stiffness'}
EITHER_IN = 'cue_ball', 'ball_table'


def resolved(data: object, folder: Path, descent: tuple[Path, ...] = ()) -> object:
    """
    Complete a scene with the values of the scene that its key `like` names.

    Parameters
    ----------
    data : object
        Content of the scene's file; `like` in it names a bundled scene or a file.
    folder : Path
        Folder that file names are relative to.
    descent : tuple of Path
        Files that inherit from this one, from which it must not inherit.

    Raises
    ------
    InputError
        If there is no such scene, or it cannot be read.

    """
    if not isinstance(data, Mapping) or LIKE not in data:
        return data
    try:
        path = find_scene(str(data[LIKE]), folder).resolve()
        if path in descent:
            allowed = 'a scene that does not inherit from this one'
            raise InputError([Mistake((), must_be(allowed, data[LIKE]))])
        other = resolved(read_yaml(path), path.parent, (*descent, path))
    except ValueError as error:
        raise InputError(found_in(error, LIKE)) from error
    return merged(other, {key: value for key, value in data.items() if key != LIKE})


def merged(base: object, own: object) -> Any:
    """Merge mappings key by key; own values replace those of the base."""
    if not isinstance(base, Mapping) or not isinstance(own, Mapping):
        return own
    result = {str(key): value for key, value in base.items()}
    for name, value in ((str(key), value) for key, value in own.items()):
        below = result.get(name)
        if name in EITHER_IN and isinstance(below, Mapping) and isinstance(value, Mapping):
            below = {key: each for key, each in below.items() if EITHER.get(key) not in value}
        result[name] = merged(below, value) if name in result else value
    return result
