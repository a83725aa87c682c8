"""
Resettable peak memory of the process: the memory of a piece of work, compiled or not.

Linux only (proc(5): clear_refs, VmRSS, VmHWM), with the resolution of a page; elsewhere NaN.
"""

import ctypes
import gc
import math
from pathlib import Path

SELF = Path('/proc/self')


def reset_peak() -> float:
    """Release unused memory, reset the peak, and return the memory in use [kB]."""
    gc.collect()
    try:
        ctypes.CDLL(None).malloc_trim(0)
        (SELF / 'clear_refs').write_text('5')
    except (AttributeError, OSError):
        return math.nan
    return _field('VmRSS')


def peak() -> float:
    """Return the peak memory since `reset_peak` [kB]."""
    return _field('VmHWM')


def _field(name: str) -> float:
    try:
        lines = (SELF / 'status').read_text().splitlines()
    except OSError:
        return math.nan
    return next((float(line.split()[1]) for line in lines if line.startswith(name)), math.nan)
