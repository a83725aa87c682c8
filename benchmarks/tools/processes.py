"""Processes that run beside a benchmark, and those that do its work."""

from concurrent.futures import as_completed, ProcessPoolExecutor
import contextlib
import math
from multiprocessing import get_context
import os
import signal
import subprocess
import sys
from time import monotonic


@contextlib.contextmanager
def processes(commands):
    """Run Python processes, by their arguments, during the block."""
    running = [subprocess.Popen([sys.executable, *command]) for command in commands]
    try:
        yield running
    finally:
        for process in running:
            process.send_signal(signal.SIGINT)
        for process in running:
            process.wait(timeout=20)


def results_of(function, calls, seconds=math.inf):
    """Yield arguments and result of each call that ends; drop those that wait after `seconds`."""
    end = monotonic() + seconds
    # Fresh processes: a fork of a process with threads can hang.
    with ProcessPoolExecutor(os.cpu_count() or 1, get_context('spawn')) as executor:
        work = {executor.submit(function, *call): call for call in calls}
        for done in as_completed(work):
            if done.cancelled():
                continue
            yield work[done], done.result()
            if monotonic() > end:
                for each in work:
                    each.cancel()
