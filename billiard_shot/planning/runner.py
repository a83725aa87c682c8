"""Evaluates strokes on all cores, within a budget, with progress reports and cancellation."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import partial
from math import ceil, inf
import os
from time import perf_counter
from typing import Any, Protocol, TypeVar

import numpy as np

from billiard_shot.planning.evaluate import evaluate_strokes, Outcomes, ValueFunction
from billiard_shot.planning.places import as_struck
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.strike_map import bounds_of, Cell, Fit, fit_cell, Maps
from billiard_shot.records import Array
from billiard_shot.shot.stroke import Stroke

T = TypeVar('T')

FINAL_RESERVE = 0.2  # part of budget and time that is kept to evaluate the best strokes
POLL_S = 0.02  # s between two calls of `progress` and `cancel` while strokes are evaluated
CHUNK, LARGEST_CHUNK = 256, 1024  # strokes of a task of the executor, some 5 to 40 ms of work
FIRST_RATE = 1e4  # strokes per second: guess until some are simulated
SHORT_TASK_S = 0.1  # of work, if there is a time limit


class SupportsSubmit(Protocol):
    """Anything with the method `submit` of executors of concurrent.futures."""

    def submit(self, work: Callable[..., Any], /, *arguments: Any) -> Future[Any]:
        """Start a task."""


@dataclass(frozen=True, slots=True)
class Progress:
    """Progress of a search."""

    simulations: int
    budget: int
    # Estimated for the best stroke so far, or its mean value; 0 if no stroke was found.
    success: float
    stroke: Stroke | None  # the best one so far


class StoppedError(Exception):
    """The search was cancelled."""


class Runner:
    """Evaluates strokes of one problem within a budget."""

    def __init__(
        self,
        problem: Problem,
        budget: int,
        executor: Executor | SupportsSubmit,
        progress: Callable[[Progress], object] | None = None,
        cancel: Callable[[], bool] | None = None,
        seconds: float | None = None,
        value: ValueFunction | None = None,
    ) -> None:
        self.budget, self.simulations, self.best = budget, 0, 0.0
        self._best_stroke: Stroke | None = None
        self.reserved = round(FINAL_RESERVE * budget)
        self._maps = Maps(problem.model, bounds_of(problem.sigmas), problem.setting.reaching)
        self._executor = executor
        self._problem, self._work = problem, partial(evaluate_strokes, problem, value=value)
        self.value = value
        self._progress, self._cancel = progress, cancel
        self._begin, self._seconds = perf_counter(), seconds

    @property
    def left(self) -> int:
        """Number of strokes that may still be evaluated, without the reserved ones."""
        left = self.budget - self.simulations - self.reserved
        if self._seconds is not None:
            left = int(min(left, self._rate * self._time_left))
        return max(left, 0)

    @property
    def scope(self) -> float:
        """Number of strokes that budget and time allow for in all."""
        return min(self.budget, self._rate * (self._seconds or inf))

    @property
    def _rate(self) -> float:
        """Evaluated strokes per second."""
        gone = perf_counter() - self._begin
        return self.simulations / gone if self.simulations else FIRST_RATE

    def _chunk(self, strokes: int) -> int:
        """
        Return how many of the strokes make a task.

        A task for each core, if these are neither small nor large; with a time limit, no more than
        about `SHORT_TASK_S` of work. The tasks are alike.
        """
        size = min(max(ceil(strokes / (os.cpu_count() or 1)), CHUNK), LARGEST_CHUNK)
        if self._seconds is not None:
            size = min(max(int(SHORT_TASK_S * self._rate), 1), size)
        return ceil(strokes / max(ceil(strokes / size), 1)) or 1

    @property
    def _time_left(self) -> float:
        """Seconds, without the reserved share while strokes are reserved."""
        return self._time_until(1.0 - FINAL_RESERVE if self.reserved else 1.0)

    @property
    def late(self) -> bool:
        """Whether only the reserved share of the time is left, or less."""
        return self._time_until(1.0 - FINAL_RESERVE) < 0.0

    def _time_until(self, share: float) -> float:
        """Seconds until a share of the time has passed."""
        if self._seconds is None:
            return inf
        return share * self._seconds - (perf_counter() - self._begin)

    def note(self, stroke: Array, value: float) -> None:
        """Report a stroke (5,) as the best one so far, if its value is larger than before."""
        if value > self.best:
            self.best, self._best_stroke = value, Stroke.from_offsets(*stroke.tolist())

    def poll(self) -> None:
        """Report progress; raise StoppedError if the search is cancelled."""
        if self._progress:
            self._progress(Progress(self.simulations, self.budget, self.best, self._best_stroke))
        if self._cancel and self._cancel():
            raise StoppedError

    def _result(self, future: Future[T]) -> T:
        """Wait for a task; raise StoppedError if the search is cancelled before."""
        # The task may end between a wait that timed out and the check of `done`. Only a task that
        # is done tells whether it raised TimeoutError itself.
        while not future.done():
            try:
                return future.result(timeout=POLL_S)
            except TimeoutError:
                self.poll()
        return future.result()

    def each(self, work: Callable[..., T], rows: Iterable[tuple[Any, ...]]) -> Iterator[T]:
        """
        Do some work on the executor for each row of arguments; yield the results in turn.

        The work that is left is cancelled if some fails, the results are not asked for any more,
        or the search is cancelled.
        """
        futures = [self._executor.submit(work, *row) for row in rows]
        try:
            for future in futures:
                yield self._result(future)
                self.poll()
        finally:
            for future in futures:
                future.cancel()

    def _fitted(self, cells: list[Cell]) -> Iterator[Fit]:
        """Fit cells of the map."""
        return self.each(fit_cell, [(self._maps.model, cell) for cell in cells])

    def evaluate(
        self,
        strokes: Array,
        places: Array | None = None,
        *,
        exact: bool = False,
        to_the_end: bool = False,
    ) -> Outcomes:
        """
        Evaluate strokes (n, 5), or the first of them if budget or time do not allow all.

        Strokes use maps of the strike where the maps are accurate enough; if `exact`, the maps are
        stricter, rebounds are solved, and tolerances are smaller. Unless `to_the_end`, a ball that
        has missed its pocket is not followed, and cannot fall by chance. `places` (n, balls, 2)
        [m]: where its balls lie.
        """
        self.poll()
        strokes = strokes[: self.left]
        if places is not None:
            places = places[: len(strokes)]
            strokes = as_struck(self._problem, strokes, places)
        size = self._chunk(len(strokes))
        parts = [slice(i, i + size) for i in range(0, len(strokes), size)]
        mapped = self._maps.mapped(strokes, self._fitted, strict=exact)
        work = partial(self._work, to_the_end=to_the_end, coarse=not exact)
        rows = [
            (strokes[part], mapped.part(part), None if places is None else places[part])
            for part in parts
        ]
        results = [Outcomes(np.empty(0, np.bool_), np.empty(0), np.empty(0))]
        for outcomes in self.each(work, rows):
            results.append(outcomes)
            self.simulations += len(outcomes.success)
            if self._time_left <= 0.0:  # these strokes take longer than those before
                break
        return Outcomes(*(np.concatenate(columns) for columns in zip(*results, strict=True)))
