"""
The machine code of the entries: compiled once, in other processes, and kept on disk.

A process interprets until the machine code is there, and then switches to it. Compiling takes tens
of seconds, so it begins only where that pays: `require` (batches, plans) waits for it, `prepare`
(nodes) begins it, and so does a process that has interpreted for some seconds. Other processes
compile, because compiling in a thread stops all others. A lock ensures that an entry is compiled
once, even if many processes need it. No process waits for one of lower
priority, so `require` compiles at the priority of its process, and `prepare` below it.

Machine code is kept in `folder()`, named after the versions and the processor that it depends on.
Each entry has a folder there, named after the content of its sources: copies of the same sources
share their machine code, wherever they are. The folders that were used last stay. If anything goes
wrong, a warning says so, and the process goes on interpreting.
"""

import atexit
from collections.abc import Callable
from contextlib import suppress
from functools import cache
import gc
import hashlib
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
import os
from pathlib import Path
import platform
import shutil
import subprocess
import sys
import tempfile
from threading import Lock, Thread
from time import monotonic, sleep
from typing import Any
import warnings

from billiard_shot.compiled import compile_entry, Entry, Interpreted
from billiard_shot.entries import ENTRIES, ENTRY_GROUPS, LAYERS

try:
    from fcntl import LOCK_EX, LOCK_SH, LOCK_UN, lockf
except ImportError:  # Windows: two processes may compile the same, which harms nothing
    lockf = None  # type: ignore[assignment]

LOADING_PAYS = 0.5  # s of interpreting after which a process loads machine code that is there,
COMPILING_PAYS = 5.0  # s and after which it compiles
POLL = 0.1  # s
KEPT = 16  # folders of an entry that stay: for the contents of its sources that were used last
BACKGROUND = 5  # niceness that `prepare` adds: nodes keep their timing meanwhile

_HERE = Path(__file__).parents[1]  # a child finds the same package from there

Report = Callable[[int, int, float], None]
"""Called with the number of compiled entries, of all entries, and the time waited so far [s]."""


@cache
def available() -> bool:
    """Whether numba can compile; if it is not installed, warn once."""
    if os.environ.get('NUMBA_DISABLE_JIT') not in (None, '', '0'):  # numba is turned off
        return False
    if find_spec('numba') is None:
        _warn(
            'numba is not installed: strokes are interpreted, which takes about 500 times as '
            "long as compiled code. Install it: pip install 'billiard_shot[fast]'"
        )
        return False
    return True


@cache
def folder() -> Path:
    """Return the folder of the machine code for these versions and this processor."""
    cache = os.environ.get('BILLIARD_SHOT_CACHE') or os.environ.get('XDG_CACHE_HOME')
    root = Path(cache or '~/.cache') / 'billiard_shot' / _platform()
    try:
        root = root.expanduser().absolute()  # for processes that work elsewhere
        root.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=root) as file:
            file.write(b'may be written')
    except (OSError, RuntimeError) as error:  # RuntimeError: this user has no home
        reason = error.strerror if isinstance(error, OSError) else error
        _warn(
            f'{root} cannot be written ({reason}): machine code is kept for this '
            'process only. Set BILLIARD_SHOT_CACHE to a folder that can be written'
        )
        temporary = tempfile.TemporaryDirectory(prefix='billiard_shot-')
        _keep.append(temporary)
        root = Path(temporary.name)
    return root


def look(seconds_interpreted: float) -> None:
    """Begin to load or to compile machine code if interpreting has taken long enough."""
    if seconds_interpreted > COMPILING_PAYS:
        prepare()
    elif seconds_interpreted >= LOADING_PAYS:
        load()


def load() -> None:
    """Begin to load machine code if all of it is compiled; return at once."""
    if not _workers and available() and is_complete():
        prepare()


def prepare() -> None:
    """Begin to compile the missing entries, and then to load all of them; return at once."""
    if not _workers:
        _start(BACKGROUND)


def require(report: Report | None = None) -> bool:
    """
    Wait for machine code; return whether there is any.

    Parameters
    ----------
    report : callable, optional
        Called several times a second while this waits, with the number of compiled entries, of all
        entries, and the seconds waited so far.

    """
    begin = monotonic()
    worker = None if is_loaded() else _start(0)
    while worker is not None and worker.is_alive():
        worker.join(POLL)
        if report is not None:
            report(sum(map(_is_compiled, ENTRIES)), len(ENTRIES), monotonic() - begin)
    return is_loaded()


def is_loaded() -> bool:
    """Whether this process runs machine code."""
    return bool(Entry.machine_code)


def is_complete() -> bool:
    """Whether all entries are compiled."""
    return all(map(_is_compiled, ENTRIES))


def _start(nice: int) -> '_Worker | None':
    """Return the worker whose processes are nicer by `nice` than this one; start it if needed."""
    with _lock:
        if nice not in _workers and available():
            _workers[nice] = _Worker(nice)
            _workers[nice].start()
        return _workers.get(nice)


class _Worker(Thread):
    """Compiles the missing entries in other processes, and loads all entries into this one."""

    def __init__(self, nice: int) -> None:
        super().__init__(name='machine code', daemon=True)
        self.nice = nice
        self.running: dict[tuple[str, ...], subprocess.Popen[bytes]] = {}
        atexit.register(self.end)

    def run(self) -> None:
        """Compile and load all entries; if anything fails, warn, and keep interpreting."""
        missing = (tuple(n for n in group if not _is_compiled(n)) for group in ENTRY_GROUPS)
        waiting = [names for names in missing if names]
        failed = why = ''
        while (waiting and not failed) or self.running:
            while waiting and not failed and len(self.running) < (os.cpu_count() or 1):
                names = waiting.pop(0)
                try:
                    self.running[names] = _child(names, self.nice)
                except OSError as error:  # the folder is gone, the disk is full
                    failed, why = names[0], str(error)
            sleep(POLL)
            for names, process in list(self.running.items()):
                code = process.poll()
                left = [name for name in names if not _is_compiled(name)]
                if not left:  # by this process, or by another one of higher priority
                    del self.running[names]
                    process.terminate()
                    process.wait()
                elif code is not None:
                    del self.running[names]
                    failed, why = left[0], _reason(names[0], code)
        if failed:
            _warn(
                f'{failed} could not be compiled, so strokes are interpreted, which is slow: {why}'
            )
            return
        with _loading:
            if not is_loaded():
                self.load()

    def load(self) -> None:
        """Load all entries."""
        try:
            machine_code = {}
            for name in ENTRIES:
                entry = _entry(name)
                machine_code[entry] = compile_entry(entry, _place(name))
                with suppress(OSError):  # a cache that can only be read
                    (_place(name) / 'done').touch()
            Entry.machine_code = machine_code
        except Exception as error:
            _warn(
                f'the machine code in {folder()} cannot be loaded ({error!r}): it is removed, '
                'and the next process compiles it again. This one interprets, which is slow'
            )
            for name in ENTRIES:
                shutil.rmtree(_place(name), ignore_errors=True)

    def end(self) -> None:
        """Stop compiling."""
        for process in self.running.values():
            process.terminate()


def _child(names: tuple[str, ...], nice: int) -> subprocess.Popen[bytes]:
    """Compile entries in another process; its log is in the folder of the first one."""
    arguments = [str(nice)]
    for name in names:
        _place(name).mkdir(exist_ok=True)
        arguments += [name, str(_place(name))]
    with (_place(names[0]) / 'log').open('wb') as log:
        return subprocess.Popen(
            [sys.executable, '-m', 'billiard_shot.machine_code', *arguments],
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            cwd=_HERE,
        )


def _entry(name: str) -> Entry:
    module, function = name.split(':')
    found: Entry = getattr(import_module(module), function)
    return found


def _place(name: str) -> Path:
    """Return the folder of an entry's machine code."""
    layer = name.split('.')[1]
    return folder() / f'{name.replace(":", ".")}.{_content(layer)}'


def _is_compiled(name: str) -> bool:
    return (_place(name) / 'done').exists()


def _reason(name: str, code: int) -> str:
    """Say why the process that compiled an entry ended with an exit code."""
    log = _place(name) / 'log'
    lines = log.read_text(errors='replace').split('\n') if log.exists() else []
    last = next((line.strip() for line in reversed(lines) if line.strip()), '')
    if last:
        return f'{last} (see {log})'
    if code < 0:
        return f'its process was ended by signal {-code}'
    return f'its process ended with code {code}, and could not write {log}'


@cache
def _content(layer: str) -> str:
    """Digest of the sources that the functions of a layer can use."""
    here = Path(__file__).parent
    files = list(here.glob('*.py'))
    for each in LAYERS[: LAYERS.index(layer) + 1]:
        files += (here / each).rglob('*.py')
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(f'{path.relative_to(here).as_posix()} {path.stat().st_size} '.encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _platform() -> str:
    """Digest of everything besides sources that machine code depends on."""
    digest = hashlib.sha256()
    for package in ('numba', 'llvmlite', 'numpy'):
        try:
            digest.update(version(package).encode())
        except PackageNotFoundError:
            digest.update(b'-')
    digest.update(f'{sys.version} {platform.machine()} {_processor()}'.encode())
    return digest.hexdigest()[:16]


def _processor() -> str:
    """Describe the processor: machine code uses all that it can do."""
    try:
        lines = Path('/proc/cpuinfo').read_text().splitlines()
    except OSError:
        return platform.processor()
    wanted = ('model name', 'flags', 'Features')
    return ' '.join(sorted({line for line in lines if line.startswith(wanted)}))


def _warn(text: str) -> None:
    # Not of a line of this file, which the warning would show.
    warnings.warn_explicit(text, RuntimeWarning, 'billiard_shot', 1)


def compile_one(name: str, place: Path) -> None:
    """Compile an entry, unless another process has done so."""
    with (place / 'lock').open('w+') as lock:
        if lockf is not None:
            _wait_for_others(lock.fileno(), os.nice(0))
        done = place / 'done'
        if not done.exists():
            compile_entry(_entry(name), place)
            done.touch()
            remove_old(place)


def remove_old(place: Path) -> None:
    """Remove machine code of older contents of an entry, all but `KEPT` that were used last."""
    entry = place.name.rpartition('.')[0]
    used = {}
    for done in place.parent.glob(f'{entry}.*/done'):
        with suppress(OSError):  # another process removes it
            used[done.parent] = done.stat().st_mtime
    for old in sorted(used, key=lambda each: -used[each])[KEPT:]:
        shutil.rmtree(old, ignore_errors=True)


def _wait_for_others(lock: int, nice: int) -> None:
    """
    Wait for processes that compile the same with the same or a higher priority.

    Each priority has its own byte of the lock's file, from 1 for the highest. A process holds the
    byte of its priority until it has compiled. It does not wait for the bytes of lower priorities.
    """
    own = nice + 21
    lockf(lock, LOCK_EX, 1, own)
    lockf(lock, LOCK_SH, own, 0)
    lockf(lock, LOCK_UN, own, 0)


_keep: list[Any] = []
_workers: dict[int, _Worker] = {}  # by the niceness of their processes
_lock = Lock()
_loading = Lock()
Interpreted.listeners.append(look)

if __name__ == '__main__':
    gc.disable()  # collecting garbage in numba's large heap takes a tenth of the time
    if lockf is not None:  # not on Windows
        os.nice(int(sys.argv[1]))
    for name, place in zip(sys.argv[2::2], sys.argv[3::2], strict=True):
        compile_one(name, Path(place))
