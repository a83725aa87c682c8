"""Strokes simulated on all cores, and their penalties; within a budget, and until cancelled."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from functools import partial
from math import ceil, inf
import os
from time import perf_counter
from typing import Any, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from billiard_shot import machine_code
from billiard_shot.planning import within_noise
from billiard_shot.planning.problem import as_struck, Problem, tables_at
from billiard_shot.planning.score import PENALTY_STEP
from billiard_shot.records import Array
from billiard_shot.scene.fields import as_floats
from billiard_shot.shot.play import task_of
from billiard_shot.shot.stroke import Stroke, vectors_of
from billiard_shot.status import Status
from billiard_shot.table.run.simulate import TableBatch
from billiard_shot.table.run.task import BatchRecording, run_recorded
from billiard_shot.table.strike.placement import ALL_SOLVED, StrikePolynomials

# A planned stroke may end with these, but not in a miscue: a sliding tip is not repeatable.
USABLE_STATUSES = (Status.OK, Status.INFINITE_SEQUENCE, Status.TOLERANCE_NOT_REACHED)
IS_USABLE = np.isin(np.arange(max(Status) + 1), USABLE_STATUSES)  # of each status
INFEASIBLE_PENALTY = 9.0  # of strokes that cannot be played
# Straight cushions that a ball to be potted may meet in the search. After more cushions it may
# still fall by chance, which only the trials of finished plans count.
SOUGHT_CUSHIONS = 2

ValueFunction = Callable[[TableBatch], Any]  # of n outcomes: (n,) numbers from 0 to 1


class Outcomes(NamedTuple):
    """Outcomes of n strokes."""

    success: NDArray[np.bool_]  # (n,) whether the target was reached
    # (n,) 0 if the target was reached; below 1 if only the last step is missing, then about the
    # remaining distance in m; one more for every earlier step that is missing
    penalty: Array
    value: Array  # (n,) from 0 to 1: of `ValueFunction`; without one, 1 if the target was reached

    def take(self, which: NDArray[np.int64]) -> Outcomes:
        """Select some of the outcomes."""
        return Outcomes(self.success[which], self.penalty[which], self.value[which])


def evaluate_strokes(
    problem: Problem,
    strokes: Array,
    mapped: StrikePolynomials = ALL_SOLVED,
    places: Array | None = None,
    *,
    to_the_end: bool = True,
    coarse: bool = False,
    value: ValueFunction | None = None,
) -> Outcomes:
    """
    Simulate strokes and find their penalties.

    Parameters
    ----------
    problem : Problem
    strokes : (n, 5) float array
        a, b, elevation, azimuth, speed; see `vectors_of`.
    mapped : StrikePolynomials
        Which strikes come from maps, see `Maps.mapped`; others are solved.
    places : (n, balls, 2) float array, optional
        Where the balls lie [m], see `draw_places`; by default where the problem has them. The
        strokes are relative to these cue balls, see `as_struck`.
    to_the_end : bool
        Whether a ball that has missed its pocket is followed further.
    coarse : bool
        Whether motion is only as accurate as a search needs: larger tolerances, and rebounds from
        a table.
    value : callable, optional
        Of outcomes; then all balls are followed to rest. A stroke that cannot be played, or whose
        tip slides, has the value 0.

    """
    rules: NDArray[np.void] | None = problem.rules
    if value is not None:
        rules = None
    elif not to_the_end:
        rules = problem.rules.copy()
        rules['sought'][list(problem.balls)] = SOUGHT_CUSHIONS if len(problem.pockets) else 0
    recording, usable = simulate_strokes(problem, strokes, mapped, places, rules, coarse)
    penalty = np.where(usable, penalties_of(problem, recording), INFEASIBLE_PENALTY)
    success = penalty == 0.0
    if value is None:
        return Outcomes(success, penalty, success.astype(float))
    return Outcomes(success, penalty, np.where(usable, _values(problem, recording, value), 0.0))


def _values(problem: Problem, recording: BatchRecording, value: ValueFunction) -> Array:
    """Ask for the values (n,) of recorded tables, and check them."""
    count = len(recording.tables)
    values = as_floats(value(TableBatch(problem.names, recording)))
    if values.shape != (count,) or not ((values >= 0.0) & (values <= 1.0)).all():
        got = f'shape {values.shape}'
        if values.shape == (count,):
            got = f'{values[~((values >= 0.0) & (values <= 1.0))][0]:g}'
        raise ValueError(f'value must return ({count},) numbers from 0 to 1, got {got}')
    return values


def penalties_of(problem: Problem, recording: BatchRecording) -> Array:
    """Find the penalty (n,) of each recorded table, see `Outcomes`."""
    fouls = problem.fouls(recording)
    return problem.target.penalties(problem, recording, fouls) + PENALTY_STEP * fouls


def simulate_strokes(
    problem: Problem,
    strokes: Array,
    mapped: StrikePolynomials = ALL_SOLVED,
    places: Array | None = None,
    rules: NDArray[np.void] | None = None,
    coarse: bool = False,
) -> tuple[BatchRecording, NDArray[np.bool_]]:
    """
    Simulate strokes on the table; return the recording, and whether each strike is usable.

    Parameters as of `evaluate_strokes`; with `rules` each table ends as soon as it is decided.
    """
    task = task_of(
        problem.prepared,
        *vectors_of(strokes),
        None if places is None else tables_at(problem, places),
        within_noise.accuracy_within(problem.sigmas) if coarse else within_noise.TRIALS,
        mapped=mapped,
        rules=rules,
    )
    recording = run_recorded(task)
    return recording, IS_USABLE[recording.cues['status']] & ~recording.cues['miscue']


T = TypeVar('T')

FINAL_RESERVE = 0.2  # part of budget and time that is kept to evaluate the best strokes
POLL_S = 0.02  # s between two calls of `progress` and `cancel` while strokes are evaluated
CHUNK, LARGEST_CHUNK = 256, 1024  # strokes of a task of the executor, some 5 to 40 ms of work
FIRST_RATE = 3e4  # strokes per second with machine code; the first ones take longer
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
        self.granted = 0  # strokes that may be evaluated although the time is up
        self._maps = within_noise.Maps(
            problem.model, within_noise.bounds_of(problem.sigmas), problem.prepared.reaching
        )
        self._executor = executor
        self._problem, self._work = problem, partial(evaluate_strokes, problem, value=value)
        self.value = value
        self._progress, self._cancel = progress, cancel
        # The time counts from the first strokes on: on a busy machine it would else be up before.
        self._begin, self._seconds = inf, seconds or inf
        self._last_rate = FIRST_RATE  # strokes per second, without the fits of maps

    @property
    def left(self) -> int:
        """Number of strokes that may still be evaluated, without the reserved ones."""
        left = self.budget - self.simulations - self.reserved
        return max(int(min(left, max(self._rate * self._time_left, self.granted))), 0)

    @property
    def scope(self) -> float:
        """Number of strokes that budget and time allow for in all."""
        return min(self.budget, self._rate * self._seconds)

    @property
    def _rate(self) -> float:
        """Strokes per second; maps make later ones faster than the first ones."""
        gone = self._gone
        if not (self.simulations and gone):
            return FIRST_RATE
        return max(self.simulations / gone, FIRST_RATE if machine_code.is_loaded() else 0.0)

    @property
    def _gone(self) -> float:
        """Seconds since the first strokes began."""
        return max(perf_counter() - self._begin, 0.0)

    def _chunk(self, strokes: int) -> int:
        """
        Return how many of the strokes make a task.

        A task for each core, if these are neither small nor large; with a time limit, no more than
        about `SHORT_TASK_S` of work. The tasks are alike.
        """
        size = min(max(ceil(strokes / (os.cpu_count() or 1)), CHUNK), LARGEST_CHUNK)
        if self.is_timed:
            size = min(max(int(SHORT_TASK_S * self._last_rate), 1), size)
        return ceil(strokes / max(ceil(strokes / size), 1)) or 1

    @property
    def _time_left(self) -> float:
        """Seconds, without the reserved share while strokes are reserved."""
        return self._time_until(1.0 - FINAL_RESERVE if self.reserved else 1.0)

    @property
    def is_timed(self) -> bool:
        """Whether there is a time limit."""
        return self._seconds < inf

    @property
    def late(self) -> bool:
        """Whether only the reserved share of the time is left, or less."""
        return self.has_used(1.0 - FINAL_RESERVE)

    def has_used(self, share: float) -> bool:
        """Whether more than a share of the time has passed."""
        return self._time_until(share) < 0.0

    def _time_until(self, share: float) -> float:
        """Seconds until a share of the time has passed."""
        return share * self._seconds - self._gone

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

    def _fitted(self, boxes: list[within_noise.Box]) -> Iterator[within_noise.BoxFit]:
        """Fit boxes of the map."""
        return self.each(within_noise.fit_box, [(self._maps.model, box) for box in boxes])

    def evaluate(
        self,
        strokes: Array,
        places: Array | None = None,
        *,
        exact: bool = False,
        to_the_end: bool = False,
        each: int = 1,
    ) -> Outcomes:
        """
        Evaluate strokes (n, 5), or the first of them if budget or time do not allow all.

        Strokes use maps of the strike where the maps are accurate enough; if `exact`, the maps are
        stricter, rebounds are solved, and tolerances are smaller. Unless `to_the_end`, a ball that
        has missed its pocket is not followed, and cannot fall by chance. `places` (n, balls, 2)
        [m]: where its balls lie. `each` as of `Maps.mapped`.
        """
        self.poll()
        strokes = strokes[: self.left]
        if places is not None:
            places = places[: len(strokes)]
            strokes = as_struck(self._problem, strokes, places)
        size = self._chunk(len(strokes))
        parts = [slice(i, i + size) for i in range(0, len(strokes), size)]
        mapped = self._maps.mapped(strokes, self._fitted, strict=exact, each=each)
        work = partial(self._work, to_the_end=to_the_end, coarse=not exact)
        rows = [
            (strokes[part], mapped.part(part), None if places is None else places[part])
            for part in parts
        ]
        begin, before = perf_counter(), self.simulations
        self._begin = min(self._begin, begin)
        results = [Outcomes(np.empty(0, np.bool_), np.empty(0), np.empty(0))]
        for outcomes in self.each(work, rows):
            results.append(outcomes)
            self.simulations += len(outcomes.success)
            count = self.simulations - before
            self._last_rate = count / max(perf_counter() - begin, 1e-6)
            # these strokes take longer than those before
            if self._time_left <= 0.0 and count >= self.granted:
                break
        return Outcomes(*(np.concatenate(columns) for columns in zip(*results, strict=True)))
