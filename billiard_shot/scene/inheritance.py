"""Inheritance of scenes: `like: pool` takes all values that are not given from scene `pool`."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from billiard_shot.scene.bundled import find_scene
from billiard_shot.scene.errors import found_in, InputError, Mistake, must_be
from billiard_shot.scene.yaml_file import read_yaml

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
