"""Timing, memory, the yardstick, the machine, and a table of limits."""

import json
import os
from pathlib import Path
import platform
import statistics
import sys
from time import perf_counter, process_time

import numpy as np

from billiard_shot import machine_code

QUICK = bool(os.environ.get('BENCHMARK_QUICK'))  # smaller samples: numbers of the same kind


def machine() -> str:
    """Describe the machine in one line."""
    name = platform.processor()
    info = Path('/proc/cpuinfo')
    if info.exists():
        lines = [line for line in info.read_text().splitlines() if line.startswith('model name')]
        name = lines[0].split(':')[1].strip() if lines else name
    versions = f'Python {platform.python_version()}, numpy {np.__version__}'
    return f'{name}, {os.cpu_count()} CPUs, {versions}'


class Time(float):
    """
    Wall time of a call [s], and its CPU time beside it.

    The ratio of two times is that of the CPU times, which do not grow while others use the cores.
    """

    cpu: float

    def __new__(cls, wall: float, cpu: float) -> 'Time':
        """Make a time."""
        made = super().__new__(cls, wall)
        made.cpu = cpu
        return made

    def __truediv__(self, other):
        """Divide by a number, or compare with another time."""
        if isinstance(other, Time):
            return self.cpu / other.cpu
        return Time(float(self) / other, self.cpu / other)

    def __mul__(self, factor: float) -> 'Time':
        """Scale."""
        return Time(float(self) * factor, self.cpu * factor)

    __rmul__ = __mul__

    def __sub__(self, other: 'Time') -> 'Time':
        """Subtract the time of a part."""
        return Time(float(self) - float(other), self.cpu - other.cpu)


def once(function, *arguments) -> Time:
    """Time of one call, on all threads."""
    wall, cpu = perf_counter(), process_time()
    function(*arguments)
    return Time(perf_counter() - wall, process_time() - cpu)


def seconds(function, *arguments, at_least: float = 0.2, repeats: int = 7) -> Time:
    """Median time of a call, over `repeats` series that take `at_least` seconds together."""
    if QUICK:
        at_least, repeats = 0.2 * at_least, 3
    function(*arguments)
    calls = max(1, int(at_least / repeats / max(once(function, *arguments), 1e-7)))

    def call_all():
        for _ in range(calls):
            function(*arguments)

    series = [once(call_all) for _ in range(repeats)]
    wall, cpu = statistics.median(map(float, series)), statistics.median(s.cpu for s in series)
    return Time(wall / calls, cpu / calls)


def in_turns(*functions, repeats: int = 7) -> list[Time]:
    """Median times of calls that take turns, so that all meet the same other work."""
    series = [[] for _ in functions]
    for number in range((3 if QUICK else repeats) + 1):
        for each, function in zip(series, functions, strict=True):
            took = once(function)
            if number:  # the first call of each loads what it needs
                each.append(took)
    return [
        Time(statistics.median(map(float, each)), statistics.median(s.cpu for s in each))
        for each in series
    ]


def yardstick() -> Time:
    """Time of one np.cross of two vectors: the unit for the overhead of a Python call."""
    a, b = np.array([1.0, 2.0, 3.0]), np.array([-2.0, 1.0, 0.5])
    return seconds(np.cross, a, b)


def resident(process) -> float:
    """Resident memory of a process [MB]."""
    lines = Path(f'/proc/{process.pid}/status').read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith('VmRSS')) * 1024 / 1e6


class Report:
    """
    Prints one row per number, and remembers the limits that were missed.

    If the variable BENCHMARK_ROWS names a file, the rows are written there too, as JSON.
    """

    def __init__(self, title: str) -> None:
        self.missed: list[str] = []
        self.rows: list[dict[str, object]] = []
        self.title = title
        self.notes: list[str] = []
        if not machine_code.is_loaded():
            sys.exit('the library is interpreted: its times say nothing')
        self._begin, self._busy = perf_counter(), busy()
        print(title)
        print(machine())

    def row(self, name: str, value: float | Time, unit: str, limit: float | None = None) -> None:
        """
        Print a number; a positive limit is an upper limit, -x is the lower limit x.

        A name that begins with a space is that of a detail, which the page leaves out if it has no
        limit.

        Of a `Time`, in s, ms or us, the wall time and the CPU time are printed.
        """
        cpu = None
        if isinstance(value, Time):
            scale = {'s': 1.0, 'ms': 1e3, 'us': 1e6}[unit]
            value, cpu = scale * float(value), scale * value.cpu
        kept = None
        verdict = ''
        if limit is not None:
            kept = bool(value <= limit if limit > 0.0 else value >= -limit)
            sign = '<=' if limit > 0.0 else '>='
            verdict = f'{sign} {abs(limit):.4g}  {"ok" if kept else "MISSED"}'
            if not kept:
                self.missed.append(name.strip())
        beside = '' if cpu is None else f'(CPU {cpu:.4g})'
        print(f'  {name:<66} {value:>10.4g} {unit:<9} {beside:<14} {verdict}', flush=True)
        row = {'name': name, 'value': float(value), 'unit': unit, 'cpu': cpu}
        self.rows.append(row | {'limit': limit, 'kept': kept})

    def note(self, text: str) -> None:
        """Say in words what was not measured."""
        self.notes.append(text)
        print(f'  {text}')

    def end(self) -> None:
        """Leave with an exit code that says whether all limits were kept."""
        wall, cpu = perf_counter() - self._begin, busy() - self._busy
        self.row(' this benchmark', Time(wall, cpu), 's')
        if path := os.environ.get('BENCHMARK_ROWS'):
            said = {'title': self.title, 'machine': machine(), 'quick': QUICK}
            Path(path).write_text(json.dumps(said | {'rows': self.rows, 'notes': self.notes}))
        if self.missed:
            print('limits missed:', '; '.join(self.missed))
        sys.exit(bool(self.missed))


def busy() -> float:
    """CPU time of this process and of those that it waited for [s]."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system
