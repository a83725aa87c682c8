"""
The tools of the build, numba and zig, where this Python has none.

They take 800 MB, and systems guard their Python (PEP 668). So they are put into an environment
that lasts for one build.
"""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import metadata
from importlib.util import find_spec
import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig
from typing import Any
import xml.etree.ElementTree as ET
from zipfile import ZipFile

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
