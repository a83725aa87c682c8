"""Batches on all cores."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
import math
import os
from typing import TypeVar

T = TypeVar('T')

LARGEST_PART = 1000
"""Rows that one thread does at once. Between two parts, Ctrl+C is answered."""


def in_threads(work: Callable[[slice], T], count: int, workers: int | None = None) -> list[T]:
    """
    Divide a batch among threads; return what each part gave, in order.

    `work` must not call this function: its thread would wait for itself.

    Parameters
    ----------
    work : callable
        Does the rows of a slice.
    count : int
        Rows of the batch.
    workers : int, optional
        Threads; by default as many as there are cores.

    """
    threads = workers or os.cpu_count() or 1
    small = max(1, math.ceil(count / (8 * threads)))  # because rows differ in cost
    size = LARGEST_PART if threads == 1 else small
    parts = [slice(i, i + size) for i in range(0, count, size)]
    if threads == 1 or len(parts) <= 1:
        return [work(part) for part in parts]
    return list(_pool(threads, os.getpid()).map(work, parts))


@cache
def _pool(threads: int, process: int) -> ThreadPoolExecutor:
    """Return threads of this process that stay, because each of them keeps its rooms."""
    del process  # a process that is forked has none of the threads of its parent
    return ThreadPoolExecutor(threads, 'batch')
