"""Executors of long commands: this process, several processes, or a Dask cluster."""

import argparse
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
import logging
from multiprocessing import active_children, parent_process
from multiprocessing.context import SpawnContext, SpawnProcess
import os
import signal
import sys
from threading import Thread
from typing import Any, ClassVar, TypeVar

from billiard_shot.cli.output import interruptible
from billiard_shot.scene.fields import whole_number

T = TypeVar('T')
R = TypeVar('R')


@dataclass(frozen=True)
class OfWork:
    """
    Who does the work.

    Parameters
    ----------
    workers : N
        Number of worker processes (default: %(default)d).
    dask : ADDRESS
        Address of a Dask scheduler, or %(LOCAL)s for a cluster of this run.

    """

    TITLE: ClassVar = 'work'
    LOCAL: ClassVar = 'local'
    workers: int = whole_number(minimum=1, default=1)
    dask: str | None = None


def mapped(options: argparse.Namespace, work: Callable[[T], R], items: Sequence[T]) -> Iterator[R]:
    """
    Do work for each item with the selected workers, and yield the results in order.

    Raises
    ------
    ValueError
        If Dask is not installed, or there is no scheduler at the address.

    """
    with working(options.workers, options.dask) as executor:
        yield from map(work, items) if executor is None else executor.map(work, items)


@contextmanager
def working(workers: int, dask: str | None) -> Iterator[Executor | None]:
    """
    Provide an executor while the block runs.

    Parameters
    ----------
    workers : int
        Number of worker processes; with 1, this process does the work.
    dask : str, optional
        Address of a Dask scheduler, or `local` for a cluster of `workers` on this machine.

    Yields
    ------
    Executor or None
        None if this process does the work.

    Raises
    ------
    ValueError
        If Dask is not installed, or there is no scheduler at the address.

    """
    if dask is not None:
        with _dask(workers, dask) as executor:
            yield executor
    elif workers == 1:
        yield None
    else:
        with _processes(workers) as executor:
            yield executor


@contextmanager
def _processes(workers: int) -> Iterator[Executor]:
    # Fresh processes: a fork of a process with threads can hang.
    others = active_children()
    pool = ProcessPoolExecutor(workers, _Workers(), begin_work)
    try:
        yield pool
    except BaseException:
        for worker in {*active_children()} - {*others}:
            worker.terminate()  # their current tasks are lost, but no longer needed
        raise
    finally:
        pool.shutdown(cancel_futures=True)


class _Worker(SpawnProcess):
    """A process whose start no Ctrl+C cuts short: half started, it would end with a traceback."""

    def start(self) -> None:
        """Start the process; a Ctrl+C that came meanwhile is raised afterwards."""
        with interruptible() as pressed:
            if sys.platform == 'win32':
                super().start()
            else:  # until `begin_work` runs, a terminal's Ctrl+C would reach the process as well
                before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
                try:
                    super().start()
                finally:
                    signal.pthread_sigmask(signal.SIG_SETMASK, before)
        if pressed():
            raise KeyboardInterrupt


class _Workers(SpawnContext):
    Process = _Worker


def begin_work() -> None:
    """In a worker: leave Ctrl-C to the first process, and end with that process."""
    _ignore_ctrl_c()
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End with the first process, even if it was killed: else a worker would wait for ever."""
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def _ignore_ctrl_c() -> None:
    """Leave Ctrl-C to the first process: in a terminal, the signal reaches all processes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _dask(workers: int, address: str) -> Iterator[Executor]:
    try:
        import distributed
    except ImportError:
        raise ValueError(
            "--dask: needs Dask, an extra: pip install 'billiard_shot[dask]'"
        ) from None
    library: Any = distributed  # it is only partly typed
    if address == OfWork.LOCAL:
        with (
            library.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                dashboard_address=None,
                silence_logs=logging.ERROR,  # at Ctrl-C it would warn of the intended end
            ) as cluster,
            library.Client(cluster) as client,
        ):
            client.run(_ignore_ctrl_c)
            yield client.get_executor()
        return
    try:
        client = library.Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise ValueError(f'--dask: {address}: {error}') from error
    with client:
        yield client.get_executor()
