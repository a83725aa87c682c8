"""
The library of these sources: built once, and kept where `billiard_shot.machine_code` looks.

`python -m billiard_shot.compiler.build FOLDER TARGET ...` builds it in a process of its own.
"""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
import hashlib
from importlib import metadata
from importlib.util import find_spec
import json
import os
from pathlib import Path
from pkgutil import resolve_name
import shutil
import subprocess
import sys
import sysconfig
from typing import Any
import xml.etree.ElementTree as ET
from zipfile import ZipFile

from billiard_shot import machine_code

REQUIRED = Path(__file__).with_name('requirements.txt')
PACKAGE = Path(__file__).parents[1]
PATIENCE = 20.0  # s, for the package index to send a wheel of this package


def missing_tool() -> str:
    """Return the name of a tool that this Python does not have, or nothing."""
    return next((tool for tool in ('numba', 'ziglang') if find_spec(tool) is None), '')


@contextmanager
def environment(folder: Path) -> Iterator[str]:
    """Make an environment with a copy of this package; yield its Python, and remove it."""
    shutil.rmtree(folder, ignore_errors=True)  # what an interrupted build left
    try:
        run('python3-venv is needed', sys.executable, '-m', 'venv', folder)
        base = {'base': str(folder)}
        site = Path(sysconfig.get_path('purelib', 'venv', base))
        shutil.copytree(PACKAGE, site / PACKAGE.name)
        yield str(Path(sysconfig.get_path('scripts', 'venv', base), 'python'))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def fetch_library(python: str, folder: Path) -> Path:
    """Return a folder, with the library of the wheel of this version if there is one."""
    options = '--no-deps', '--only-binary', ':all:', '--retries', '0', '--dest', folder
    wheel = f'{PACKAGE.name}=={_version()}'
    with suppress(RuntimeError):  # there is no such wheel, or no index, as the tools will tell
        run('', python, '-m', 'pip', 'download', *options, wheel, timeout=PATIENCE)
    for file in folder.glob('*.whl'):
        with ZipFile(file) as opened:
            opened.extractall(folder)
    return folder / PACKAGE.name / 'library'


def install(python: str) -> None:
    """Install the tools into an environment, and what the compiled modules import."""
    options = '--only-binary', ':all:', '--retries', '2', '-r', REQUIRED
    failed = 'numba and ziglang cannot be installed'
    run(failed, python, '-m', 'pip', 'install', *options, 'pyyaml')


def run(failed: str, *command: str | Path, lines: int = 1, **options: Any) -> None:
    """
    Run a command with options of `subprocess.run`.

    Raises
    ------
    OSError
        If it cannot be run, or takes longer than `timeout` [s].
    RuntimeError
        If it fails. The message ends with the last lines of its output.

    """
    # Other Pythons must not import the modules of this one.
    options.setdefault('env', {key: os.environ[key] for key in os.environ if 'PYTHON' not in key})
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    except subprocess.TimeoutExpired:
        raise TimeoutError('the package index does not answer') from None
    if done.returncode:
        said = (done.stdout + done.stderr).splitlines() or [f'exit code {done.returncode}']
        raise RuntimeError(f'{failed}: ' + '\n'.join(said[-lines:]))


def _version() -> str | None:
    """Return the version of these sources, which need not be installed."""
    file = PACKAGE.with_name('package.xml')
    return ET.parse(file).findtext('version') if file.exists() else metadata.version(PACKAGE.name)


try:
    from fcntl import LOCK_EX, lockf
except ImportError:  # Windows: two processes may build the same, which harms nothing
    lockf = None  # type: ignore[assignment]

ENTRIES = (
    'billiard_shot.impact.kernel:solve_collisions',
    'billiard_shot.table.run.task:play_tables',
    'billiard_shot.planning.score:measure_tables',
    'billiard_shot.planning.direct_shots:find_direct_shots',
    'billiard_shot.shot.stroke:write_strokes',
    'billiard_shot.shot.lowest_elevation:write_clear_elevations',
)
"""The compiled entries of the package; no other file names them."""

KEPT = 8  # libraries that stay: of the sources that were asked for last
CAPTURED = 'entries.bc'  # all targets are built from it
PAGES = 'wasm32'  # the target of the core in pages
HEADER = 'billiard_shot.h'
NOTICE = 'COPYRIGHT.musl'  # the licence of the functions of musl, which libraries contain


def provide(*targets: str, install: bool = False) -> Path:
    """
    Return the folder with the library of these sources; build the targets that are missing.

    Parameters
    ----------
    *targets : str
        Names of `targets.TARGETS`; by default that of this machine.
    install : bool
        Whether tools of the build that are not installed are fetched, for this build only.

    Raises
    ------
    ModuleNotFoundError
        If a tool of the build is not installed.
    OSError, RuntimeError
        If the library cannot be built.

    """
    folder = machine_code.built()
    _complete(folder, targets or (machine_code.LIBRARY,), install)
    os.utime(folder)
    remove_old(folder.parent)
    return folder


def pack(folder: Path, scratch: Path, target: str = machine_code.LIBRARY) -> None:
    """
    Put the library for a target, and the one for browsers, into a folder of a wheel.

    What is missing is built in a folder `scratch`, because a build of a package leaves nothing
    elsewhere. Raises as `provide`.
    """
    shutil.rmtree(folder, ignore_errors=True)  # it may be of other sources
    targets = target, PAGES
    for made in (machine_code.PACKAGED, machine_code.built(), scratch):
        if not _missing(made, targets):
            break
    else:
        if machine_code.built().exists():  # perhaps all but one target
            ignored = shutil.ignore_patterns('tools', 'lock')
            shutil.copytree(machine_code.built(), scratch, ignore=ignored, dirs_exist_ok=True)
        _complete(scratch, targets, install=True)
    folder.mkdir(parents=True)
    libraries = (f'{each}.*' for each in targets)
    for pattern in (*libraries, machine_code.DESCRIPTION, HEADER, NOTICE):
        for file in made.glob(pattern):
            shutil.copy(file, folder)


def _missing(folder: Path, targets: Iterable[str]) -> list[str]:
    """Return the targets of which a folder has no library of these sources."""
    return [each for each in targets if not any(map(_is_sound, folder.glob(f'{each}.*')))]


def _complete(folder: Path, targets: tuple[str, ...], install: bool) -> None:
    """Build the targets that are missing in a folder, in one process at a time."""
    folder.mkdir(parents=True, exist_ok=True)
    with _locked(folder / 'lock'):
        missing, tool = _missing(folder, targets), missing_tool()
        if missing and not tool:
            _build_apart(sys.executable, folder, missing)
        elif missing and install:
            _build_in_environment(folder, missing)
        elif missing:
            raise ModuleNotFoundError(f'{tool} is not installed', name=tool)


def _build_in_environment(folder: Path, targets: list[str]) -> None:
    """Build with an environment of its own, unless a wheel of these sources is to be had."""
    with environment(folder / 'tools') as python:
        fetched = fetch_library(python, folder / 'tools' / 'wheel')
        if len(_missing(fetched, targets)) < len(targets):
            shutil.copytree(fetched, folder, dirs_exist_ok=True)
        if missing := _missing(folder, targets):
            install(python)
            _build_apart(python, folder, missing)


def _build_apart(python: str, folder: Path, targets: list[str]) -> None:
    """Build in another process: after a capture, numba cannot be used for anything else."""
    options: dict[str, Any] = {'cwd': folder, 'lines': 30}
    if python == sys.executable:  # it finds this package here; an environment has a copy
        options |= {'cwd': PACKAGE.parent, 'env': os.environ}
    module = f'{__package__}.build'
    run('the library cannot be built', python, '-m', module, folder, *targets, **options)


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
        from billiard_shot.compiler.description import describe, header_of

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
