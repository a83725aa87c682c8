"""Scenes like others: `like: pool` takes everything from that scene but what is written here."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from billiard_shot.scene.bundled import find_scene
from billiard_shot.scene.mistakes import InputError, Mistake
from billiard_shot.scene.yaml_file import read_yaml

LIKE = 'like'


def resolved(data: object, folder: Path, descent: tuple[Path, ...] = ()) -> object:
    """
    Fill in what a scene says it has in common with another one.

    Parameters
    ----------
    data : object
        What the scene's file holds; `like` in it names a bundled scene or a file.
    folder : Path
        Where the names of files are relative to.
    descent : tuple of Path
        Files that are like this one, which it must not be like.

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
            raise ValueError(f'{data[LIKE]!r} is not allowed; that scene is like this one')
        other = resolved(read_yaml(path), path.parent, (*descent, path))
    except ValueError as error:
        raise InputError([Mistake((LIKE,), str(error))]) from error
    return merged(other, {key: value for key, value in data.items() if key != LIKE})


def merged(base: object, own: object) -> Any:
    """Own values where there are any, else those of the base; mappings are merged key by key."""
    if not isinstance(base, Mapping) or not isinstance(own, Mapping):
        return own
    result = {str(key): value for key, value in base.items()}
    for name, value in ((str(key), value) for key, value in own.items()):
        result[name] = merged(result[name], value) if name in result else value
    return result
