"""The library of these sources: built once, and kept where `billiard_shot.machine_code` looks."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager, suppress
import hashlib
from importlib import import_module
from importlib.util import find_spec
import json
import os
from pathlib import Path
import shutil
import subprocess
import sys
import tempfile

from billiard_shot import machine_code
from billiard_shot.compiled import Entry
from billiard_shot.compiler.description import describe
from billiard_shot.entries import ENTRIES

try:
    from fcntl import LOCK_EX, lockf
except ImportError:  # Windows: two processes may build the same, which harms nothing
    lockf = None  # type: ignore[assignment]

KEPT = 8  # libraries that stay: of the sources that were built last
EVERYWHERE = 'wasm'  # the target beside that of this machine


def provide() -> Path:
    """Return the folder with the library of these sources; build it if it is not there."""
    folder = machine_code.built()
    folder.mkdir(parents=True, exist_ok=True)
    with _locked(folder / 'lock'):
        if not _is_there(folder):
            with tempfile.TemporaryDirectory() as scratch:
                _build_apart(scratch)
                files = sorted(Path(scratch).iterdir(), key=_is_description)  # the last one
                for file in files:
                    shutil.copy(file, folder / f'{file.name}.new')
                    os.replace(folder / f'{file.name}.new', folder / file.name)
        os.utime(folder)
        remove_old(folder.parent)
    return folder


def _build_apart(folder: str) -> None:
    """Build in another process: numba cannot be used for anything else after a capture."""
    for tool in ('numba', 'ziglang'):
        if find_spec(tool) is None:
            raise ModuleNotFoundError(f'{tool} is not installed', name=tool)
    done = subprocess.run(
        [sys.executable, '-m', 'billiard_shot.compiler', folder],
        cwd=Path(__file__).parents[2],  # there it finds the same package
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise RuntimeError(done.stderr.strip()[-2000:] or f'exit code {done.returncode}')


def build(folder: Path, targets: Sequence[str] = (machine_code.LIBRARY, EVERYWHERE)) -> None:
    """
    Write the library, its description, and the licence of the functions in it.

    Parameters
    ----------
    folder : Path
    targets : sequence of str
        Names of `TARGETS`.

    Raises
    ------
    ValueError
        If the library cannot be built for a target.

    """
    from billiard_shot.compiler.capture import capture
    from billiard_shot.compiler.targets import compile_for, LICENCE, TARGETS

    unknown = set(targets) - set(TARGETS)
    if unknown:
        raise ValueError(
            f'the library cannot be built for {", ".join(unknown)}; only for {", ".join(TARGETS)}'
        )
    entries = [_entry(name) for name in ENTRIES]
    description = describe(entries)
    bitcode, names = capture(entries).as_bitcode(), list(description['entries'])
    with ProcessPoolExecutor(min(len(targets), os.cpu_count() or 1)) as pool:
        running = [
            pool.submit(compile_for, TARGETS[target], bitcode, names, folder) for target in targets
        ]
        for each in running:
            each.result()
    for target in targets:
        file = folder / TARGETS[target].file
        description['files'][file.name] = hashlib.sha256(file.read_bytes()).hexdigest()
    shutil.copy(LICENCE, folder / 'COPYRIGHT.musl')
    (folder / machine_code.DESCRIPTION).write_text(json.dumps(description, indent=1))


def _entry(name: str) -> Entry:
    module, function = name.split(':')
    found: Entry = getattr(import_module(module), function)
    return found


def _is_there(folder: Path) -> bool:
    """Whether a folder has a library that this process could load."""
    for file in folder.glob(f'{machine_code.LIBRARY}.*'):
        with suppress(OSError, ValueError):
            machine_code.library_at(file)
            return True
    return False


def _is_description(file: Path) -> bool:
    return file.name == machine_code.DESCRIPTION


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
