"""Timing, memory, the yardstick, the machine, and a table of limits."""

import os
from pathlib import Path
import platform
import statistics
import sys
from time import perf_counter

import numba
import numpy as np

from billiard_shot import machine_code


def machine() -> str:
    """Describe the machine in one line."""
    name = platform.processor()
    info = Path('/proc/cpuinfo')
    if info.exists():
        lines = [line for line in info.read_text().splitlines() if line.startswith('model name')]
        name = lines[0].split(':')[1].strip() if lines else name
    versions = f'Python {platform.python_version()}, numpy {np.__version__}'
    return f'{name}, {os.cpu_count()} CPUs, {versions}, numba {numba.__version__}'


def seconds(function, *arguments, at_least: float = 0.2, repeats: int = 7) -> float:
    """Median time of a call, over `repeats` series that take `at_least` seconds together."""
    function(*arguments)
    begin = perf_counter()
    function(*arguments)
    once = max(perf_counter() - begin, 1e-7)
    calls = max(1, int(at_least / repeats / once))
    series = []
    for _ in range(repeats):
        begin = perf_counter()
        for _ in range(calls):
            function(*arguments)
        series.append((perf_counter() - begin) / calls)
    return statistics.median(series)


def yardstick() -> float:
    """Time of one np.cross of two vectors: the unit for the overhead of a Python call."""
    a, b = np.array([1.0, 2.0, 3.0]), np.array([-2.0, 1.0, 0.5])
    return seconds(np.cross, a, b)


def resident(process) -> float:
    """Resident memory of a process [MB]."""
    lines = Path(f'/proc/{process.pid}/status').read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith('VmRSS')) * 1024 / 1e6


class Report:
    """Prints one row per number, and remembers the limits that were missed."""

    def __init__(self, title: str) -> None:
        self.missed: list[str] = []
        machine_code.require()
        print(title)
        print(machine())

    def row(self, name: str, value: float, unit: str, limit: float | None = None) -> None:
        """Print a number; a positive limit is an upper limit, -x is the lower limit x."""
        verdict = ''
        if limit is not None:
            kept = value <= limit if limit > 0.0 else value >= -limit
            sign = '<=' if limit > 0.0 else '>='
            verdict = f'{sign} {abs(limit):g}  {"ok" if kept else "MISSED"}'
            if not kept:
                self.missed.append(name)
        print(f'  {name:<66} {value:>10.4g} {unit:<9} {verdict}')

    def end(self) -> None:
        """Leave with an exit code that says whether all limits were kept."""
        if self.missed:
            print('limits missed:', '; '.join(self.missed))
        sys.exit(bool(self.missed))
