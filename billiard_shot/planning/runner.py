"""Strokes played on all cores: counted against the budget, reported, and given up when told so."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np

from billiard_shot.planning.play import Outcomes, play
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.strikes import Rows

RESERVE = 0.2  # part of the budget that is kept to judge the best strokes by
PATIENCE = 0.02  # s between two looks whether to end
PART = 64  # strokes played at a stretch: some 7 ms, after which `cancel` is asked


class Submits(Protocol):
    """Anything that takes work as the executors of concurrent.futures do."""

    def submit(self, work: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Begin a piece of work."""


@dataclass(frozen=True, slots=True)
class Progress:
    """How far a search has come."""

    simulations: int
    budget: int
    success: float  # of the best stroke so far, as estimated so far; 0: none


class StoppedError(Exception):
    """The search was cancelled."""


class Runner:
    """Plays strokes of one problem within a budget."""

    def __init__(
        self,
        problem: Problem,
        budget: int,
        executor: Executor | Submits,
        progress: Callable[[Progress], object] | None,
        cancel: Callable[[], bool] | None,
    ) -> None:
        self.budget, self.played, self.best = budget, 0, 0.0
        self.reserved = round(RESERVE * budget)
        self._work, self._executor = partial(play, problem), executor
        self._progress, self._cancel = progress, cancel

    @property
    def left(self) -> int:
        """How many strokes may still be played, without those that are reserved for later."""
        return max(self.budget - self.played - self.reserved, 0)

    def look(self) -> None:
        """Report progress; raise StoppedError if the search is to end."""
        if self._progress:
            self._progress(Progress(self.played, self.budget, self.best))
        if self._cancel and self._cancel():
            raise StoppedError

    def _result(self, future: Future[Outcomes]) -> Outcomes:
        """Wait for strokes to be played, but no longer than until the search is to end."""
        while True:
            try:
                return future.result(timeout=PATIENCE)
            except TimeoutError:
                if future.done():
                    raise
                self.look()

    def play(self, strokes: Rows) -> Outcomes:
        """Play strokes (n, 5), all or as many as the budget allows: the first ones."""
        self.look()
        strokes = strokes[: self.left]
        parts = [strokes[i : i + PART] for i in range(0, len(strokes), PART)]
        futures = [self._executor.submit(self._work, part) for part in parts]
        results = []
        try:
            for part, future in zip(parts, futures, strict=True):
                results.append(self._result(future))
                self.played += len(part)
                self.look()
        except BaseException:
            for future in futures:
                future.cancel()
            raise
        if not results:
            return Outcomes(np.empty(0, np.bool_), np.empty(0), np.empty((0, 2)))
        return Outcomes(*(np.concatenate(columns) for columns in zip(*results, strict=True)))
