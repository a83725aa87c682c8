"""
Paths of the bundled scenes.

Their files are in config/scenes. `pip install` and `colcon build` copy that folder into the
package as `billiard_shot/scenes`; a source checkout (also `pip install -e`) reads it in place.
"""

from pathlib import Path

from billiard_shot.scene.errors import must_be_one_of, refused

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
