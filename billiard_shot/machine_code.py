"""
The library of machine code: where it lies, and whether it belongs to the modules of this process.

`billiard_shot.compiler` builds it ahead of time from the entries, with a description of how they
are called (`DESCRIPTION`). A process loads it when it first calls an entry, which takes
milliseconds. If there is no library, or only one of other sources or of another system, a warning
says what to do, and the process interprets. Nothing here imports numba.
"""

from collections.abc import Iterator
from contextlib import suppress
import ctypes
from functools import cache
import hashlib
import json
import os
from pathlib import Path
import platform
import sys
from typing import Any, NamedTuple
import warnings

DESCRIPTION = 'description.json'
LIBRARY = f'{platform.system()}-{platform.machine()}'.lower()  # its name, without a suffix
_HERE = Path(__file__).parent
PACKAGED = _HERE / 'library'  # in a wheel
# Folders of the sources that the library depends on.
LAYERS = ('numerics', 'impact', 'scene', 'table', 'shot', 'planning', 'compiler')


class Library(NamedTuple):
    """A library of machine code, and its description."""

    functions: ctypes.CDLL
    description: dict[str, Any]


def is_loaded() -> bool:
    """Whether this process runs machine code; load it at the first call."""
    return library() is not None


def is_interpreting() -> bool:
    """Whether this process is told to interpret, by its environment."""
    return os.environ.get('BILLIARD_SHOT_INTERPRET', '0') not in ('', '0')


@cache
def library() -> Library | None:
    """Return the library; without one, warn once and return None."""
    if is_interpreting():
        return None
    reason = ''
    for path in _candidates():
        try:
            found = library_at(path)
        except (OSError, ValueError) as error:
            reason = f' ({error})'
            continue
        with suppress(OSError):  # builds remove libraries that were not used for long
            os.utime(path.parent)
        return found
    # Not of a line of this file, which the warning would show.
    warnings.warn_explicit(
        'there is no library of machine code for these sources, so strokes are interpreted, '
        f'which takes about 500 times as long{reason}. To build it: billiard-shot compile',
        RuntimeWarning,
        'billiard_shot',
        1,
    )
    return None


def library_at(path: Path) -> Library:
    """Load a library; raise as `description_of`, or OSError if it is of another system."""
    from billiard_shot.records import record_layout  # with NumPy, which builds of the package lack

    description = description_of(path)
    for name, layout in description['records'].items():
        module, _, record = name.partition(':')
        # The others are laid out by the same rules; to import them takes longer than all the rest.
        if module in sys.modules and record_layout(getattr(sys.modules[module], record)) != layout:
            raise ValueError(f'{path} has another layout of {record}')
    return Library(ctypes.CDLL(str(path)), description)


def description_of(path: Path) -> dict[str, Any]:
    """
    Return the description of a library, which is beside it.

    Raises
    ------
    OSError, ValueError
        If it cannot be read, is damaged, or does not belong to the sources of this process.

    """
    description = json.loads(path.with_name(DESCRIPTION).read_bytes())
    if not isinstance(description, dict) or description.get('sources') != sources():
        raise ValueError(f'{path} was built from other sources')
    if description['files'].get(path.name) != hashlib.sha256(path.read_bytes()).hexdigest():
        raise ValueError(f'{path} is damaged')  # to load it would crash
    return description


def _candidates() -> Iterator[Path]:
    """Find libraries for this system."""
    named = os.environ.get('BILLIARD_SHOT_LIBRARY')
    if named:
        yield Path(named).absolute()  # only a path is no name of a library of the system
        return
    for folder in (PACKAGED, built()):
        yield from folder.glob(f'{LIBRARY}.*')


def built() -> Path:
    """Return the folder for the library that is built from these sources."""
    cache = os.environ.get('BILLIARD_SHOT_CACHE') or os.environ.get('XDG_CACHE_HOME') or '~/.cache'
    try:
        root = Path(cache).expanduser()
    except RuntimeError:  # this user has no home
        root = Path(cache)
    return root.absolute() / 'billiard_shot' / sources()


@cache
def sources() -> str:
    """Digest of all sources that the library depends on; not of this file."""
    files = [path for path in _HERE.glob('*.py') if path.name != Path(__file__).name]
    for layer in LAYERS:
        files += (_HERE / layer).rglob('*.py')
    digest = hashlib.sha256()
    for path in sorted(files):
        content = path.read_bytes()
        digest.update(f'{path.relative_to(_HERE).as_posix()} {len(content)} '.encode())
        digest.update(content)
    return digest.hexdigest()[:16]
