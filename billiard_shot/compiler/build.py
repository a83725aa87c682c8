"""
The library of these sources: built once, and kept where `billiard_shot.machine_code` looks.

`python -m billiard_shot.compiler.build FOLDER TARGET ...` builds it in a process of its own.
"""

from collections.abc import Iterator
from contextlib import contextmanager
import hashlib
from importlib.util import find_spec
import json
import os
from pathlib import Path
from pkgutil import resolve_name
import shutil
import subprocess
import sys
from typing import Any

from billiard_shot import machine_code
from billiard_shot.compiler.description import describe
from billiard_shot.compiler.header import HEADER, header_of
from billiard_shot.entries import ENTRIES

try:
    from fcntl import LOCK_EX, lockf
except ImportError:  # Windows: two processes may build the same, which harms nothing
    lockf = None  # type: ignore[assignment]

KEPT = 8  # libraries that stay: of the sources that were asked for last
CAPTURED = 'entries.bc'  # all targets are built from it
PAGES = 'wasm32'  # the target of the core in pages
NOTICE = 'COPYRIGHT.musl'  # the licence of the functions of musl, which libraries contain


def provide(*targets: str) -> Path:
    """
    Return the folder with the library of these sources; build the targets that are missing.

    Parameters
    ----------
    *targets : str
        Names of `targets.TARGETS`; by default that of this machine.

    Raises
    ------
    ModuleNotFoundError
        If a tool of the build is not installed.
    OSError, RuntimeError
        If the library cannot be built.

    """
    folder = machine_code.built()
    folder.mkdir(parents=True, exist_ok=True)
    with _locked(folder / 'lock'):
        wanted = targets or (machine_code.LIBRARY,)
        missing = [each for each in wanted if not any(map(_is_sound, folder.glob(f'{each}.*')))]
        if missing:
            _build_apart(folder, missing)
        os.utime(folder)
        remove_old(folder.parent)
    return folder


def pack(folder: Path) -> None:
    """Put the library for this machine, and the one for browsers, into a folder of a wheel."""
    targets = machine_code.LIBRARY, PAGES
    made = provide(*targets)
    folder.mkdir(parents=True, exist_ok=True)
    libraries = (f'{target}.*' for target in targets)
    for pattern in (*libraries, machine_code.DESCRIPTION, HEADER, NOTICE):
        for file in made.glob(pattern):
            shutil.copy(file, folder)


def _build_apart(folder: Path, targets: list[str]) -> None:
    """Build in another process: after a capture, numba cannot be used for anything else."""
    for tool in ('numba', 'ziglang'):
        if find_spec(tool) is None:
            raise ModuleNotFoundError(f'{tool} is not installed', name=tool)
    done = subprocess.run(
        [sys.executable, '-m', __name__, folder, *targets],
        cwd=Path(__file__).parents[2],  # there it finds the same package
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(done.stderr.strip()[-2000:] or f'exit code {done.returncode}')


def build(folder: Path, targets: list[str]) -> None:
    """Write the library for targets; its description, header and licences come with it."""
    from billiard_shot.compiler.targets import compile_for, LICENCE, TARGETS

    for target in targets:
        if target not in TARGETS:
            raise SystemExit(f'target must be one of {", ".join(TARGETS)}, got {target!r}')
    captured = folder / CAPTURED
    if _is_sound(captured):
        description, code = machine_code.description_of(captured), captured.read_bytes()
    else:
        from billiard_shot.compiler.capture import capture

        entries = [resolve_name(name) for name in ENTRIES]
        description, code = describe(entries), capture(entries)
        _write(captured, code, description)
        _write(folder / NOTICE, LICENCE.read_bytes(), description)
        _write(folder / HEADER, header_of(description, entries).encode(), description)
    for target in targets:
        made = compile_for(TARGETS[target], code, list(description['entries']))
        _write(folder / f'{target}{TARGETS[target].suffix}', made, description)


def _write(file: Path, content: bytes, description: dict[str, Any]) -> None:
    """Write a file, and the description that names it."""
    description['files'][file.name] = hashlib.sha256(content).hexdigest()
    described = json.dumps(description, indent=1).encode()
    for path, each in ((file, content), (file.with_name(machine_code.DESCRIPTION), described)):
        path.with_name('new').write_bytes(each)
        path.with_name('new').replace(path)  # at once, for processes that read it


def _is_sound(file: Path) -> bool:
    """Whether a file of a library is of these sources, and as it was built."""
    try:
        machine_code.description_of(file)
    except (OSError, ValueError):
        return False
    return True


def remove_old(root: Path) -> None:
    """Remove all libraries but those that were built or asked for last."""
    used = sorted(root.glob('*/lock'), key=lambda lock: lock.parent.stat().st_mtime)
    for lock in used[:-KEPT]:
        shutil.rmtree(lock.parent, ignore_errors=True)


@contextmanager
def _locked(file: Path) -> Iterator[None]:
    """Wait for other processes that build the same."""
    with file.open('w') as lock:
        if lockf is not None:
            lockf(lock, LOCK_EX)
        yield


if __name__ == '__main__':
    build(Path(sys.argv[1]), sys.argv[2:])
