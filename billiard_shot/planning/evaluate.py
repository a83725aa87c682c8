"""Simulation of many strokes at once, and their penalties."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from billiard_shot.planning.noises import accuracy_within, TRIALS
from billiard_shot.planning.outcome_targets import penalties_at_rest
from billiard_shot.planning.places import tables_at
from billiard_shot.planning.problem import Problem
from billiard_shot.planning.score import Goal, Kind, Runs, score_tables, Sought
from billiard_shot.records import Array
from billiard_shot.scene.values import as_floats
from billiard_shot.shot.play import play_by
from billiard_shot.shot.stroke import vectors_of
from billiard_shot.status import Status
from billiard_shot.table.mapped_strike import ALL_SOLVED, Mapped
from billiard_shot.table.motion import SegmentRecord
from billiard_shot.table.play_tables import BallOutcome, TableOutcome
from billiard_shot.table.simulation_state import BallRule
from billiard_shot.table.table_batch import batch_of, TableBatch
from billiard_shot.table.task import BatchRecording, run_recorded

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

    def take(self, which: NDArray[np.int64]) -> 'Outcomes':
        """Select some of the outcomes."""
        return Outcomes(self.success[which], self.penalty[which], self.value[which])


def evaluate_strokes(
    problem: Problem,
    strokes: Array,
    mapped: Mapped = ALL_SOLVED,
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
    mapped : Mapped
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
    values = as_floats(value(batch_of(recording, problem.names)))
    if values.shape != (count,) or not ((values >= 0.0) & (values <= 1.0)).all():
        got = f'shape {values.shape}'
        if values.shape == (count,):
            got = f'{values[~((values >= 0.0) & (values <= 1.0))][0]:g}'
        raise ValueError(f'value must return ({count},) numbers from 0 to 1, got {got}')
    return values


def penalties_of(problem: Problem, recording: BatchRecording) -> Array:
    """Find the penalty (n,) of each recorded table, see `Outcomes`."""
    run = score_tables.current()
    array, from_rows = run.storage.array, run.storage.from_rows
    penalties = run.storage.zeros(len(recording.tables))
    sought = Sought(
        from_rows(Goal, problem.goal),
        from_rows(BallRule, problem.rules),
        array(problem.wanted),
        array(problem.places),
        array(problem.holes),
    )
    runs = Runs(
        from_rows(BallOutcome, recording.balls.ravel()),
        from_rows(TableOutcome, recording.tables),
        from_rows(SegmentRecord, recording.segments),
        run.storage.zeros(len(recording.segments)),
        run.storage.zeros(len(problem.places)),
    )
    run(sought, runs, penalties)
    found = np.asarray(penalties)
    if problem.goal[0]['kind'] == Kind.FOULS:
        found = found + penalties_at_rest(problem, batch_of(recording, problem.names), found)
    return found


def simulate_strokes(
    problem: Problem,
    strokes: Array,
    mapped: Mapped = ALL_SOLVED,
    places: Array | None = None,
    rules: NDArray[np.void] | None = None,
    coarse: bool = False,
) -> tuple[BatchRecording, NDArray[np.bool_]]:
    """
    Simulate strokes on the table; return the recording, and whether each strike is usable.

    Parameters as of `evaluate_strokes`; with `rules` each table ends as soon as it is decided.
    """
    recording = play_by(
        run_recorded,
        problem.setting,
        *vectors_of(strokes),
        None if places is None else tables_at(problem, places),
        accuracy_within(problem.sigmas) if coarse else TRIALS,
        mapped=mapped,
        rules=rules,
    )
    return recording, IS_USABLE[recording.cues['status']] & ~recording.cues['miscue']
