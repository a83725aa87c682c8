"""
Run the tests of the nodes again and again, every other time with all cores busy: `make soak`.

    python test/ros/soak.py [RUNS] [ARGUMENTS FOR PYTEST...]
"""

from collections.abc import Iterator
import contextlib
import os
from pathlib import Path
import subprocess
import sys

ROOT = Path(__file__).resolve().parents[2]
LOGS = ROOT / 'log'
HOW = ['-n', '3', '--dist', 'loadgroup', '--no-loadscope-reorder', '-m', 'ros', 'test/ros']
"""As in `make test`."""


@contextlib.contextmanager
def busy_cores(count: int) -> Iterator[None]:
    """Keep cores busy meanwhile."""
    loops = [subprocess.Popen([sys.executable, '-c', 'while True: pass']) for _ in range(count)]
    try:
        yield
    finally:
        for loop in loops:
            loop.kill()
            loop.wait()


def outcome_of(arguments: list[str], log: Path, what: str) -> bool:
    """Run tests, and say how they ended; return whether all passed."""
    with log.open('w') as file:
        code = subprocess.run(
            [sys.executable, '-m', 'pytest', *arguments],
            cwd=ROOT,
            stdout=file,
            stderr=subprocess.STDOUT,
            check=False,
        ).returncode
    where = f' ({log})' if code else ''
    print(f'{what}: {log.read_text().splitlines()[-1]}{where}', flush=True)
    return code == 0


def main(runs: str = '20', *arguments: str) -> None:
    """Run, say how every run ended, and exit with the number of runs that failed."""
    LOGS.mkdir(exist_ok=True)
    failures = 0
    for run in range(1, int(runs) + 1):
        cores = 0 if run % 2 else os.cpu_count() or 1
        with busy_cores(cores):
            what = f'run {run} of {runs}, {cores} cores busy'
            failures += not outcome_of([*HOW, *arguments], LOGS / f'soak-{run}.log', what)
    sys.exit(failures)


if __name__ == '__main__':
    main(*sys.argv[1:])
