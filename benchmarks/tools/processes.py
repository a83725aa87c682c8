"""Processes that run beside a benchmark."""

import contextlib
import signal
import subprocess
import sys


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
