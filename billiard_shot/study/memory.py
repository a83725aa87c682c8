"""
The most memory that the process has had, resettable: what a piece of work needs, compiled or not.

Linux only (proc(5): clear_refs, VmRSS, VmHWM), to the page; elsewhere NaN.
"""

import ctypes
import gc
import math
from pathlib import Path

SELF = Path('/proc/self')


def reset_peak() -> float:
    """Give unused memory back, forget the highest so far, and return what is in use [kB]."""
    gc.collect()
    try:
        ctypes.CDLL(None).malloc_trim(0)
        (SELF / 'clear_refs').write_text('5')
    except (AttributeError, OSError):
        return math.nan
    return _field('VmRSS')


def peak() -> float:
    """Return the most that was in use since `reset_peak` [kB]."""
    return _field('VmHWM')


def _field(name: str) -> float:
    try:
        lines = (SELF / 'status').read_text().splitlines()
    except OSError:
        return math.nan
    return next((float(line.split()[1]) for line in lines if line.startswith(name)), math.nan)
