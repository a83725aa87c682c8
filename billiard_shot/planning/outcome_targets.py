"""Targets that are judged by where all balls rest: safeties and breaks."""

import numpy as np

from billiard_shot.planning.problem import Problem
from billiard_shot.planning.score import distance_penalty, PENALTY_STEP
from billiard_shot.planning.shots import shots
from billiard_shot.planning.targets import ANY, Break, Safe
from billiard_shot.records import Array
from billiard_shot.table.motion import NOTHING
from billiard_shot.table.table_batch import TableBatch


def penalties_at_rest(problem: Problem, outcomes: TableBatch, fouls: Array) -> Array:
    """
    Find the penalties (n,) of tables at rest: 0 if the target is reached, see `Outcomes`.

    Parameters
    ----------
    problem : Problem
    outcomes : TableBatch
        n tables.
    fouls : (n,) float array
        The penalties so far. Strokes that are fouls need no closer look.

    """
    match problem.target:
        case Break(_, pots):
            fallen = _fallen(problem, outcomes)
            missing: Array = PENALTY_STEP * np.maximum(pots - fallen, 0)
            return missing
        case Safe(_, against, chance):
            penalties = np.zeros(len(fouls))
            quiet = ~outcomes.to_cushion.any(axis=1) & (_fallen(problem, outcomes) == 0)
            penalties[quiet] = PENALTY_STEP
            legal = np.flatnonzero((fouls == 0.0) & ~quiet)
            wanted = None if ANY in against else against
            left = outcomes.states.take(legal)
            found = shots(problem.scene, left, wanted, problem.noise, workers=1)
            penalties[legal] = [distance_penalty(best - chance) for best in found.best.tolist()]
            return penalties
    return np.zeros(len(fouls))


def _fallen(problem: Problem, outcomes: TableBatch) -> Array:
    """Count the balls (n,) that fell, without those that must stay."""
    may_fall = ~problem.rules['must_stay']
    fallen: Array = (may_fall & (outcomes.pocket != NOTHING)).sum(axis=1)
    return fallen
