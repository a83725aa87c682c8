"""Evaluates strokes on all cores, within a budget, with progress reports and cancellation."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np

from billiard_shot.planning.evaluate import evaluate_strokes, Outcomes
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.strikes import Array

RESERVE = 0.2  # part of the budget that is kept to evaluate the best strokes
POLL_S = 0.02  # s between two calls of `progress` and `cancel` while strokes are evaluated
CHUNK = 64  # strokes of one task of the executor, some 7 ms of work


class SupportsSubmit(Protocol):
    """Anything with the method `submit` of executors of concurrent.futures."""

    def submit(self, work: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Start a task."""


@dataclass(frozen=True, slots=True)
class Progress:
    """Progress of a search."""

    simulations: int
    budget: int
    success: float  # estimated for the best stroke so far; 0 if there is none


class StoppedError(Exception):
    """The search was cancelled."""


class Runner:
    """Evaluates strokes of one problem within a budget."""

    def __init__(
        self,
        problem: Problem,
        budget: int,
        executor: Executor | SupportsSubmit,
        progress: Callable[[Progress], object] | None,
        cancel: Callable[[], bool] | None,
    ) -> None:
        self.budget, self.simulations, self.best = budget, 0, 0.0
        self.reserved = round(RESERVE * budget)
        self._work, self._executor = partial(evaluate_strokes, problem), executor
        self._progress, self._cancel = progress, cancel

    @property
    def left(self) -> int:
        """Number of strokes that may still be evaluated, without the reserved ones."""
        return max(self.budget - self.simulations - self.reserved, 0)

    def poll(self) -> None:
        """Report progress; raise StoppedError if the search is cancelled."""
        if self._progress:
            self._progress(Progress(self.simulations, self.budget, self.best))
        if self._cancel and self._cancel():
            raise StoppedError

    def _result(self, future: Future[Outcomes]) -> Outcomes:
        """Wait for a task; raise StoppedError if the search is cancelled before."""
        while True:
            try:
                return future.result(timeout=POLL_S)
            except TimeoutError:
                if future.done():
                    raise
                self.poll()

    def evaluate(self, strokes: Array) -> Outcomes:
        """Evaluate strokes (n, 5), or the first of them if the budget does not allow all."""
        self.poll()
        strokes = strokes[: self.left]
        parts = [strokes[i : i + CHUNK] for i in range(0, len(strokes), CHUNK)]
        futures = [self._executor.submit(self._work, part) for part in parts]
        results = []
        try:
            for part, future in zip(parts, futures, strict=True):
                results.append(self._result(future))
                self.simulations += len(part)
                self.poll()
        except BaseException:
            for future in futures:
                future.cancel()
            raise
        if not results:
            return Outcomes(np.empty(0, np.bool_), np.empty(0), np.empty((0, 2)))
        return Outcomes(*(np.concatenate(columns) for columns in zip(*results, strict=True)))
