"""Goals to play a shot: each shot is played once, and within a limited time."""

from collections.abc import Container
from dataclasses import dataclass

from billiard_shot.cue.outcome import GoalOutcome, RefusedError
from billiard_shot.cue.plan import ShotPlan

REMEMBERED = 10_000
"""Number of shot ids that are remembered; the oldest is dropped first."""


@dataclass(frozen=True, slots=True)
class ShotGoal:
    """
    A goal to play a plan.

    Parameters
    ----------
    plan : ShotPlan
    remaining : float
        Time for which the goal remains valid [s].

    """

    plan: ShotPlan
    remaining: float


def remember(shot_id: str, played: dict[str, None]) -> None:
    """Note that the cue is aimed for a shot, in the ids of all shots so far."""
    played[shot_id] = None
    if len(played) > REMEMBERED:
        del played[next(iter(played))]


def check_goal(goal: ShotGoal, played: Container[str], max_validity: float) -> None:
    """
    Check whether a goal may be played.

    Parameters
    ----------
    goal : ShotGoal
    played : container of str
        Ids of the shots for which the cue has been aimed.
    max_validity : float
        Longest time for which a goal may be valid [s].

    Raises
    ------
    RefusedError
        ALREADY_PLAYED, ALREADY_EXPIRED or INVALID_PLAN, with the reason.

    """
    if goal.plan.shot_id in played:
        raise RefusedError(
            GoalOutcome.ALREADY_PLAYED,
            f'shot_id must be new, got {goal.plan.shot_id!r}: the cue has been aimed for it '
            'before',
        )
    if not goal.remaining > 0.0:
        raise RefusedError(
            GoalOutcome.ALREADY_EXPIRED,
            f'expiry must be ahead of now, got {-goal.remaining:.3g} s ago',
        )
    if goal.remaining > max_validity:
        raise RefusedError(
            GoalOutcome.INVALID_PLAN,
            f'expiry must be at most {max_validity:g} s ahead, got {goal.remaining:.6g} s',
        )
